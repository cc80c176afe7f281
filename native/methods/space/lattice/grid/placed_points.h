// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/methods/space/lattice/grid/blend_kernels.h"

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace sinew {

/// Where a point lies in a lattice.
struct LatticePlace
{
    int cell = 0;
    Vector3 local = Vector3::Zero();
    bool outside = false;
    /// Weights of the corners of a cell of eight corners; they count where `weighted` is set.
    bool weighted = false;
    std::array<double, 8> weights{};
};

/// Points of which each is moved by the control points of one cell, in blocks of eight points of the same
/// cell. Memory: 29 bytes per point; up to a fifth more, as not all blocks are full.
class PlacedPoints
{
public:
    using CellOf = std::function<BlendCell(int)>;

    PlacedPoints() = default;
    /// \param places  one per point.
    PlacedPoints(const std::vector<LatticePlace>& places, int cells);

    /// positions = base + blended moves. Allocates nothing of the size of the points.
    /// \param cell_of         the moves of this frame, by cell; any thread may call it.
    /// \param base            (n, 3)
    /// \param[out] positions  (n, 3), row-major
    template <class Real>
    void blend(const CellOf& cell_of, PointsView base, Real* positions) const;

    std::int64_t bytes() const;

private:
    struct Block
    {
        int cell, count;
    };
    struct Weighted
    {
        int point, cell;
        std::array<double, 8> weights;
    };
    std::vector<Block> blocks_;
    std::vector<int> order_;    ///< (blocks, lanes) the points of each block
    std::vector<double> local_; ///< (blocks, 3, lanes)
    std::vector<Weighted> weighted_;
};

} // namespace sinew
