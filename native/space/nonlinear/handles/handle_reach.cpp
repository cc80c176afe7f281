// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/nonlinear/handles/handle_reach.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {

namespace {

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
    for (int p = 0; p < held_.rows(); ++p)
        bins_[bin_of(held_.row(p).transpose())].push_back(p);
}

std::array<int, 3> HandleReach::bin_of(const Vector3& point) const
{
    std::array<int, 3> bin{};
    for (int axis = 0; axis < 3; ++axis)
        bin[axis] = static_cast<int>(std::floor(std::clamp(point[axis] / radius_, -1e9, 1e9)));
    return bin;
}

void HandleReach::add_to(Shares& shares, const Vector3& point, int first) const
{
    std::map<int, double> strengths; // f of each handle
    const std::array<int, 3> own = bin_of(point);
    for (int k = 0; k < 27; ++k) {
        const auto bin = bins_.find({own[0] + k % 3 - 1, own[1] + k / 3 % 3 - 1, own[2] + k / 9 - 1});
        if (bin == bins_.end())
            continue;
        for (const int p : bin->second) {
            const double r = (held_.row(p).transpose() - point).norm() / radius_;
            if (r >= 1.0)
                continue;
            const double f = handles_.weight(p) * (1.0 - r * r * (3.0 - 2.0 * r));
            double& strongest = strengths[handles_.handle_of(p)];
            if (f > strongest && have_common(shares, shares_[p]))
                strongest = f;
        }
    }
    for (const auto& [handle, f] : strengths)
        if (f >= 1.0) {
            shares.assign(1, {first + handle, 1.0});
            return;
        }
    double whole = 0.0;
    for (const BlendedMaps::Share& share : shares)
        whole += share.weight;
    for (const auto& [handle, f] : strengths)
        if (f > 0.0)
            shares.push_back({first + handle, whole * f / (1.0 - f)}); // BlendedMaps divides by the sum
}

void append_displacements(const std::vector<HandleMotion>& motions, Poses& maps)
{
    for (const HandleMotion& motion : motions) {
        Pose& map = maps.emplace_back();
        map.leftCols<3>() = motion.turn;
        map.col(3) = motion.move;
    }
}

} // namespace sinew
