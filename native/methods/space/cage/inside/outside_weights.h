// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/methods/space/cage/cage.h"
#include "native/methods/space/cage/closed_forms/cage_geometry.h"

#include <memory>
#include <optional>
#include <vector>

namespace sinew {

/// The weights of points outside the cage.
class OutsideWeights
{
public:
    OutsideWeights(const Cage& cage, CageOutside choice);

    /// Whether points outside have weights.
    bool reaches() const { return geometry_.has_value(); }
    /// Overwrites the rows of the points that are flagged, if points outside have weights.
    void fill(PointsView block, const std::vector<char>& outside, RowMatrix& rows) const;

private:
    std::optional<CageGeometry> geometry_; ///< for mean value weights
    std::shared_ptr<const SmoothCage> smooth_;
};

} // namespace sinew
