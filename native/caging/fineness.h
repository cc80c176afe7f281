// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <utility>
#include <vector>

namespace sinew {

/// A ball beside which a cage is to be finer.
struct Detail
{
    Vector3 centre;
    double radius;

    bool operator==(const Detail&) const = default;
};

/// How fine a cage is where. Its edges have a usual length; beside details, they are at most 0.6 times as
/// long as the distance from the middle of a detail, or as its radius, whichever is more. So the number of
/// faces grows with the number of details, and only slowly as details get smaller.
class Fineness
{
public:
    /// 1 everywhere.
    Fineness() = default;
    /// \param usual  the usual length
    /// \param least  no edge need be shorter
    Fineness(std::vector<Detail> details, double usual, double least)
        : details_(std::move(details)), usual_(usual), least_(least)
    {
    }

    /// How many times as short as usual edges are at a point, >= 1.
    double at(const Vector3& point) const;

private:
    std::vector<Detail> details_;
    double usual_ = 1.0, least_ = 0.0;
};

} // namespace sinew
