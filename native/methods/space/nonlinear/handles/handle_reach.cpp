// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/handles/handle_reach.h"

#include "native/core/parallel.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace sinew {

namespace {

constexpr double near_pieces = 0.25; ///< of the size of the larger one

bool have_common(const HandleReach::Shares& a, const HandleReach::Shares& b)
{
    return std::ranges::any_of(a, [&](const auto& one) {
        return std::ranges::any_of(b, [&](const auto& other) { return one.map == other.map; });
    });
}

} // namespace

HandleReach::HandleReach(const HandleControl& handles, Points held, const std::vector<Shares>& shares,
                         double radius)
    : handles_(handles), held_(std::move(held)), shares_(shares), radius_(radius)
{
    for (int h = 0; h < handles.count(); ++h) {
        std::vector<BoxTree::Box> boxes;
        for (int k = 0; k < handles.held().count(h); ++k)
            boxes.emplace_back(Vector3(held_.row(handles.held().begin(h) + k).transpose()));
        trees_.emplace_back(boxes);
    }
}

double HandleReach::strength(int handle, const Shares& shares, const Vector3& point) const
{
    double strongest = 0.0;
    trees_[handle].visit_by_bound(
        handles_.held().count(handle), radius_,
        [&](const BoxTree::Box& box, bool) { return box.exteriorDistance(point); },
        [&](int k) {
            const int p = handles_.held().begin(handle) + k;
            if (!have_common(shares, shares_[p]))
                return radius_;
            const double r = (held_.row(p).transpose() - point).norm() / radius_;
            strongest = handles_.held().weight(p) * std::max(0.0, 1.0 - r * r * (3.0 - 2.0 * r));
            return 0.0; // the others are farther away
        });
    return strongest;
}

void HandleReach::add_to(Shares& shares, const Vector3& point, int first) const
{
    double whole = 0.0;
    for (const BlendedMaps::Share& share : shares)
        whole += share.weight;
    Shares added;
    for (int h = 0; h < handles_.count(); ++h) {
        const double f = strength(h, shares, point);
        if (f >= 1.0) {
            shares.assign(1, {first + h, 1.0});
            return;
        }
        if (f > 0.0)
            added.push_back({first + h, whole * f / (1.0 - f)}); // BlendedMaps divides by the sum
    }
    shares.insert(shares.end(), added.begin(), added.end());
}

std::vector<double> holds(const HandlePoints& handles, const Points& held, const Points& carriers,
                          double radius)
{
    std::vector<double> result(static_cast<std::size_t>(held.rows()), 1.0);
    parallel_for(static_cast<int>(held.rows()), [&](int p) {
        const double far = (held.row(p) - carriers.row(p)).norm();
        if (far <= radius)
            return;
        double least = std::numeric_limits<double>::infinity();
        for (int q = 0; q < held.rows(); ++q)
            if (handles.handle_of(q) != handles.handle_of(p))
                least = std::min(least, (held.row(q) - carriers.row(p)).norm());
        result[p] = std::clamp(2.0 - far / (least + radius), 0.0, 1.0);
    });
    return result;
}

bool are_near(double gap, const Points& one, const Points& other)
{
    const auto diagonal = [](const Points& points) {
        return (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
    };
    return gap <= near_pieces * std::max(diagonal(one), diagonal(other));
}

std::vector<HeldMotion> with_rest(std::vector<HeldMotion> motions)
{
    motions.push_back({Matrix3::Zero(), Vector3::Zero()});
    return motions;
}

void append_displacements(const std::vector<HeldMotion>& motions, Poses& maps)
{
    for (const HeldMotion& motion : motions) {
        Pose& map = maps.emplace_back();
        map.leftCols<3>() = motion.turn;
        map.col(3) = motion.move;
    }
}

} // namespace sinew
