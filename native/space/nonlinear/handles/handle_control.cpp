// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/nonlinear/handles/handle_control.h"

#include "native/core/errors.h"
#include "native/core/symmetric.h"
#include "native/operators/rotation_fit.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numeric>
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

void require_valid(const HeldPoints& held)
{
    if (held.counts.empty())
        throw InvalidConstraint("handles: there is none; at least one has to move the shape");
    std::vector<int> empty;
    for (int h = 0; h < static_cast<int>(held.counts.size()); ++h)
        if (held.counts[h] < 1)
            empty.push_back(h);
    if (!empty.empty())
        throw InvalidConstraint("handles " + list_some(empty) + " hold no points", Error::Element::handle,
                                empty);
    const auto sum = std::accumulate(held.counts.begin(), held.counts.end(), Eigen::Index{0});
    if (sum != held.points.rows())
        throw InvalidConstraint("handles: the counts add up to " + std::to_string(sum) + ", and there are " +
                                std::to_string(held.points.rows()) + " points");
    if (!held.weights.empty() && static_cast<Eigen::Index>(held.weights.size()) != sum)
        throw InvalidConstraint("handles: " + std::to_string(held.weights.size()) + " weights for " +
                                std::to_string(sum) + " points");
    std::vector<int> broken;
    for (int h = 0, p = 0; h < static_cast<int>(held.counts.size()); p += held.counts[h++])
        if (!held.points.middleRows(p, held.counts[h]).allFinite())
            broken.push_back(h);
    if (!broken.empty())
        throw InvalidConstraint("handles " + list_some(broken) + " hold points that are not finite",
                                Error::Element::handle, broken);
    for (const double weight : held.weights)
        if (!(weight > 0.0 && weight <= 1.0))
            throw InvalidOption("weights: " + std::to_string(weight) + " is not in (0, 1]");
}

} // namespace

HandleControl::HandleControl(HeldPoints held, const Vector3& centre, double unit)
    : held_(std::move(held)), centre_(centre), unit_(unit)
{
    require_valid(held_);
    for (int h = 0; h < count(); ++h)
        handle_of_.insert(handle_of_.end(), held_.counts[h], h);
    places_ = (held_.points.rowwise() - centre.transpose()) / unit;
    for (int h = 0, first = 0; h < count(); first += held_.counts[h++])
        extents_.push_back(extent(first, held_.counts[h]));

    std::vector<int> order(handle_of_.size());
    std::iota(order.begin(), order.end(), 0);
    const auto place = [&](int p) {
        return std::array{held_.points(p, 0), held_.points(p, 1), held_.points(p, 2)};
    };
    std::ranges::sort(order, [&](int a, int b) { return std::pair(place(a), a) < std::pair(place(b), b); });
    for (std::size_t k = 1; k < order.size(); ++k) {
        const int a = order[k - 1], b = order[k];
        if (place(a) == place(b) && handle_of_[a] != handle_of_[b] && weight(a) == 1.0 && weight(b) == 1.0)
            coincident_.push_back({a, b});
    }
}

HandleControl::Extent HandleControl::extent(int first, int count) const
{
    const auto own = places_.middleRows(first, count);
    Extent result{first, 0, own.colwise().mean().transpose(), Matrix3::Zero()};
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

HeldMotion HandleControl::fit(const Extent& extent, int count, PointsView posed) const
{
    const Points moves =
        (posed.middleRows(extent.first, count) - held_.points.middleRows(extent.first, count)) / unit_;
    HeldMotion motion{Matrix3::Zero(), moves.colwise().mean().transpose()};
    if (moves.isZero(0.0))
        return motion;
    const Points from = places_.middleRows(extent.first, count).rowwise() - extent.middle.transpose();
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
        motion.turn =
            Eigen::Quaterniond::FromTwoVectors(line, S * line).toRotationMatrix() - Matrix3::Identity();
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
        if (posed.middleRows(extents_[h].first, held_.counts[h]).allFinite())
            motions[h] = fit(extents_[h], held_.counts[h], posed);
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
    for (const auto& [a, b] : coincident_) {
        const Vector3 y = places_.row(a).transpose();
        const int first = handle_of_[a], second = handle_of_[b];
        if ((motions[first](y) - motions[second](y)).norm() > together)
            throw InvalidConstraint("handles " + std::to_string(first) + " and " + std::to_string(second) +
                                        " hold points at one place and take them to two: take one of them "
                                        "out of a handle, or move both alike",
                                    Error::Element::handle, {first, second});
    }
}

} // namespace sinew
