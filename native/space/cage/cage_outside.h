// SPDX-License-Identifier: GPL-3.0-or-later
// For every method of this room.
#pragma once

#include "native/space/cage/mean_value.h"

#include <optional>
#include <vector>

namespace sinew {

/// What becomes of points outside the cage, where a method has no weights.
enum class CageOutside {
    refuse,    ///< bind() names them
    mean_value ///< they get the weights of MeanValue; a warp jumps where the cage is crossed
};

/// The weights of points outside.
class OutsideWeights
{
public:
    OutsideWeights(const Cage& cage, CageOutside choice);

    bool reaches() const { return mean_value_.has_value(); }
    /// Overwrites the rows of the points that are flagged, where there are weights for them.
    void fill(PointsView block, const std::vector<char>& outside, RowMatrix& rows) const;

private:
    class Blocks : public MeanValue
    {
    public:
        using MeanValue::evaluate;
        using MeanValue::MeanValue;
    };
    std::optional<Blocks> mean_value_;
};

} // namespace sinew
