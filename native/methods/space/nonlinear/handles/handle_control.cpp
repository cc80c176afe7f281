// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/handles/handle_control.h"

#include "native/core/dense.h"
#include "native/core/errors.h"
#include "native/operators/fits/rotation_fit.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace sinew {

namespace {

/// How far two handles may take one point apart, as a share of the unit: more than rounding in Blender's
/// single precision leaves.
constexpr double together = 1e-5;
/// Points count as flat where they are spread by less than this share of their width, and as one point
/// where they are spread by less than that in units.
constexpr double flat = 1e-6, nothing = 1e-12;

} // namespace

HandleControl::HandleControl(HandlePoints held, const Vector3& centre, double unit)
    : held_(std::move(held)), centre_(centre), unit_(unit)
{
    places_ = (held_.points().rowwise() - centre.transpose()) / unit;
    for (int h = 0; h < count(); ++h)
        extents_.push_back(extent(h));
}

HandleControl::Extent HandleControl::extent(int handle) const
{
    const auto own = this->own(places_, handle);
    Extent result{0, own.colwise().mean().transpose(), Matrix3::Zero()};
    const Points relative = own.rowwise() - result.middle.transpose();
    const Matrix3 moment = relative.transpose() * relative;
    const Vector3 spread = eigenvectors(moment).values; // rising
    const double least = std::max(flat * flat * spread[2], nothing * nothing);
    for (int axis = 0; axis < 3; ++axis)
        result.rank += spread[axis] > least;
    if (result.rank == 3)
        result.inverse = moment.inverse();
    return result;
}

HeldMotion HandleControl::fit(int handle, PointsView posed) const
{
    const Extent& extent = extents_[handle];
    const Points moves = (own(posed, handle) - own(held_.points(), handle)) / unit_;
    HeldMotion motion{Matrix3::Zero(), moves.colwise().mean().transpose()};
    if (moves.isZero(0.0))
        return motion;
    const Points from = own(places_, handle).rowwise() - extent.middle.transpose();
    const Points apart = moves.rowwise() - motion.move.transpose();
    const Matrix3 S = (from + apart).transpose() * from;
    if (extent.rank == 3) {
        motion.turn = apart.transpose() * from * extent.inverse;
    } else if (extent.rank == 2) {
        motion.turn = fit_rotation(S) - Matrix3::Identity();
    } else if (extent.rank == 1) {
        Eigen::Index farthest = 0;
        from.rowwise().squaredNorm().maxCoeff(&farthest);
        const Vector3 line = from.row(farthest).transpose();
        motion.turn = smallest_turn(line, S * line).toRotationMatrix() - Matrix3::Identity();
    }
    motion.move -= motion.turn * extent.middle;
    return motion;
}

std::vector<HeldMotion> HandleControl::motions(const Poses& poses) const
{
    if (static_cast<int>(poses.size()) != count())
        throw InvalidConstraint("poses: " + std::to_string(poses.size()) + " given for " +
                                std::to_string(count()) + " handles");
    std::vector<HeldMotion> motions;
    for (const Pose& pose : poses) {
        const Matrix3 turn = pose.leftCols<3>() - Matrix3::Identity();
        motions.push_back({turn, (turn * centre_ + pose.col(3)) / unit_});
    }
    check(motions);
    return motions;
}

std::vector<HeldMotion> HandleControl::motions(PointsView posed) const
{
    if (posed.rows() != places_.rows())
        throw InvalidConstraint("handles: " + std::to_string(posed.rows()) + " points given for " +
                                std::to_string(places_.rows()));
    std::vector<HeldMotion> motions(extents_.size(), {Matrix3::Zero(), Vector3::Constant(NAN)});
    for (int h = 0; h < count(); ++h)
        if (own(posed, h).allFinite())
            motions[h] = fit(h, posed);
    check(motions);
    return motions;
}

void HandleControl::check(const std::vector<HeldMotion>& motions) const
{
    std::vector<int> broken;
    for (int h = 0; h < count(); ++h)
        if (!motions[h].turn.allFinite() || !motions[h].move.allFinite())
            broken.push_back(h);
    if (!broken.empty())
        throw InvalidConstraint("the poses of handles " + list_some(broken) + " are not finite",
                                Error::Element::handle, broken);
    for (const auto& [a, b] : held_.twins()) {
        const Vector3 y = places_.row(a).transpose();
        const int first = held_.handle_of(a), second = held_.handle_of(b);
        if ((motions[first](y) - motions[second](y)).norm() > together)
            throw InvalidConstraint("handles " + std::to_string(first) + " and " + std::to_string(second) +
                                        " hold points at one place and take them to two: take one of them "
                                        "out of a handle, or move both alike",
                                    Error::Element::handle, {first, second});
    }
}

} // namespace sinew
