// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/caging/fineness.h"

#include <algorithm>

namespace sinew {

namespace {

constexpr double share = 0.6; // of the distance from a detail, for an edge

} // namespace

double Fineness::at(const Vector3& point) const
{
    double length = usual_;
    for (const auto& [centre, radius] : details_)
        length = std::min(length, std::max(share * std::max(radius, (point - centre).norm()), least_));
    return usual_ / length;
}

} // namespace sinew
