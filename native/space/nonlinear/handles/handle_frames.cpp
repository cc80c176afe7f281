// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/nonlinear/handles/handle_frames.h"

#include "native/core/errors.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

namespace sinew {

namespace {

/// How far two handles may take one point apart, as a share of the unit: more than rounding in Blender's
/// single precision leaves.
constexpr double together = 1e-5;

void check(const HandlePoints& held)
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

HandleFrames::HandleFrames(HandlePoints held, const Vector3& centre, double unit)
    : held_(std::move(held)), centre_(centre), unit_(unit)
{
    check(held_);
    for (int h = 0; h < count(); ++h)
        handle_of_.insert(handle_of_.end(), held_.counts[h], h);
    rest_.resize(4 * static_cast<Eigen::Index>(count()), 3);
    for (int h = 0; h < count(); ++h)
        for (int k = 0; k < 4; ++k) {
            rest_.row(4 * h + k) = centre.transpose();
            if (k > 0)
                rest_(4 * h + k, k - 1) += unit;
        }

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

Points HandleFrames::posed(const Poses& poses) const
{
    if (static_cast<int>(poses.size()) != count())
        throw InvalidConstraint("poses: " + std::to_string(poses.size()) + " given for " +
                                std::to_string(count()) + " handles");
    Points control(rest_.rows(), 3);
    for (Eigen::Index k = 0; k < rest_.rows(); ++k)
        control.row(k) = apply(poses[k / 4], rest_.row(k).transpose()).transpose();
    return control;
}

std::vector<HandleMotion> HandleFrames::motions(PointsView control) const
{
    if (control.rows() != rest_.rows())
        throw InvalidConstraint("handles: " + std::to_string(control.rows()) + " points given for " +
                                std::to_string(count()) + " frames of four points");
    std::vector<HandleMotion> motions(count());
    std::vector<int> broken;
    for (int h = 0; h < count(); ++h) {
        const Eigen::Matrix<double, 4, 3> moves =
            (control.middleRows<4>(4 * h) - rest_.middleRows<4>(4 * h)) / unit_;
        if (!moves.allFinite())
            broken.push_back(h);
        motions[h].move = moves.row(0).transpose();
        for (int axis = 0; axis < 3; ++axis)
            motions[h].turn.col(axis) = (moves.row(axis + 1) - moves.row(0)).transpose();
    }
    if (!broken.empty())
        throw InvalidConstraint("the poses of handles " + list_some(broken) + " are not finite",
                                Error::Element::handle, broken);
    for (const auto& [a, b] : coincident_) {
        const Vector3 y = (held_.points.row(a).transpose() - centre_) / unit_;
        const int first = handle_of_[a], second = handle_of_[b];
        if ((motions[first](y) - motions[second](y)).norm() > together)
            throw InvalidConstraint("handles " + std::to_string(first) + " and " + std::to_string(second) +
                                        " hold points at one place and take them to two: take one of them "
                                        "out of a handle, or move both alike",
                                    Error::Element::handle, {first, second});
    }
    return motions;
}

} // namespace sinew
