// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <cstdint>
#include <vector>

namespace sinew {

/// Points that each follow a few of many affine maps, by weights that sum to 1:
///
///     x' = x + sum_j w_j D_j(y),    D_j the displacement of map j: (3, 4), y -> N y + n
///
/// The maps are blended first, so that a point costs twelve multiplications per weight and one product. Eight
/// bytes are kept per weight (its map, and the weight in single precision) and four per point; a frame reads
/// them once. With four weights, that is 36 bytes per point. The largest weight is read as 1 less the others,
/// so that rounding takes nothing from the sum: where all maps are one, it is reproduced exactly.
class BlendedMaps
{
public:
    struct Share
    {
        int map;
        double weight; ///< >= 0
    };

    /// Appends a point. \param shares  at least one; their sum is positive and need not be 1.
    void add(const std::vector<Share>& shares);

    int point_count() const { return static_cast<int>(offsets_.size()) - 1; }
    std::int64_t bytes() const;
    std::vector<Share> shares(int point) const;

    /// \param maps    the displacements D.
    /// \param centre  what `at` is measured from.
    /// \param at      (n, 3) y + centre
    /// \param base    (n, 3) x
    template <class Real>
    void apply(const Poses& maps, const Vector3& centre, PointsView at, PointsView base, Real* out) const;

private:
    std::vector<int> offsets_{0};
    std::vector<int> maps_;
    std::vector<float> weights_;
};

} // namespace sinew
