// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/sequence/edit_keys.h"

#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/handles/map_blend.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace sinew {

namespace {

constexpr double full_turn = 2 * std::numbers::pi;
constexpr double off_diagonal = std::numbers::sqrt2; ///< so that the norm of six numbers is that of S

/// The rotation vector of R that is nearest to another one.
Vector3 nearest_turn(const Matrix3& R, const Vector3& before)
{
    const Vector3 turn = rotation_between(Eigen::Quaterniond::Identity(), Eigen::Quaterniond(R));
    const double angle = turn.norm();
    Vector3 axis = before;
    if (angle > 0)
        axis = turn / angle;
    else if (before.norm() > 0)
        axis = before.normalized();
    const double turns = std::round((axis.dot(before) - angle) / full_turn);
    return turn + turns * full_turn * axis;
}

template <int from, int count, class Numbers>
void set_slope(const Numbers& a, const Numbers& b, Numbers& slope)
{
    const auto u = a.template segment<count>(from), v = b.template segment<count>(from);
    const double along = u.dot(v), both = u.squaredNorm() + v.squaredNorm();
    if (along > 0)
        slope.template segment<count>(from) = along / both * (u + v);
}

template <class Numbers>
Pose edit_of(const Numbers& value)
{
    const Vector3 turn = value.template segment<3>(3);
    const double angle = turn.norm();
    Matrix3 R = Matrix3::Identity(), S;
    if (angle > 0)
        R = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
    const double yz = value[9] / off_diagonal, xz = value[10] / off_diagonal, xy = value[11] / off_diagonal;
    S << value[6], xy, xz, xy, value[7], yz, xz, yz, value[8];
    Pose edit;
    edit << R * S, value.template head<3>();
    return edit;
}

Pose unedited()
{
    Pose pose = Pose::Zero();
    pose.leftCols<3>().setIdentity();
    return pose;
}

} // namespace

EditKeys::EditKeys(const std::vector<EditKey>& keys)
{
    std::vector<std::vector<EditKey>> per_handle;
    for (std::size_t k = 0; k < keys.size(); ++k) {
        const std::string name = "keys: key " + std::to_string(k);
        if (!std::isfinite(keys[k].frame) || !keys[k].edit.allFinite())
            throw InvalidOption(name + " has a number that is not finite");
        if (keys[k].handle < 0)
            throw InvalidOption(name + " names handle " + std::to_string(keys[k].handle));
        if (keys[k].handle >= static_cast<int>(per_handle.size()))
            per_handle.resize(keys[k].handle + 1);
        per_handle[keys[k].handle].push_back(keys[k]);
    }
    for (std::vector<EditKey>& some : per_handle) {
        std::ranges::stable_sort(some, {}, &EditKey::frame);
        for (std::size_t k = 1; k < some.size(); ++k)
            if (some[k].frame == some[k - 1].frame)
                throw InvalidOption("keys: handle " + std::to_string(some[k].handle) +
                                    " has two keys at frame " + shortest(some[k].frame));
        tracks_.push_back(track_of(some));
    }
}

EditKeys::Track EditKeys::track_of(const std::vector<EditKey>& keys)
{
    Track track;
    for (const EditKey& key : keys) {
        const Polar polar(key.edit.leftCols<3>());
        const Vector3 before = track.empty() ? Vector3(0, 0, 0) : Vector3(track.back().value.segment<3>(3));
        const Vector3 turn = nearest_turn(polar.R, before);
        Numbers value;
        value << key.edit.col(3), turn, polar.S.diagonal(), off_diagonal * polar.S(1, 2),
            off_diagonal * polar.S(0, 2), off_diagonal * polar.S(0, 1);
        track.push_back({key.frame, key.edit, value, Numbers::Zero()});
    }
    const auto slope = [&](std::size_t k) -> Numbers {
        return (track[k + 1].value - track[k].value) / (track[k + 1].frame - track[k].frame);
    };
    for (std::size_t k = 1; k + 1 < track.size(); ++k) {
        const Numbers before = slope(k - 1), after = slope(k);
        set_slope<0, 3>(before, after, track[k].slope);
        set_slope<3, 3>(before, after, track[k].slope);
        set_slope<6, 6>(before, after, track[k].slope);
    }
    return track;
}

Pose EditKeys::at(int handle, double frame) const
{
    if (handle < 0 || handle >= handle_count() || tracks_[handle].empty())
        return unedited();
    const Track& track = tracks_[handle];
    const auto next = std::ranges::upper_bound(track, frame, {}, &Knot::frame);
    if (next == track.begin())
        return track.front().edit;
    const Knot& a = *(next - 1);
    if (next == track.end() || frame == a.frame || a.edit == next->edit)
        return a.edit;
    const Knot& b = *next;
    const double h = b.frame - a.frame, t = (frame - a.frame) / h, s = 1 - t;
    return edit_of(Numbers(s * s * (1 + 2 * t) * a.value + t * t * (3 - 2 * t) * b.value +
                           h * t * s * (s * a.slope - t * b.slope)));
}

} // namespace sinew
