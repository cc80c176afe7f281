// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/lattice/grid/placed_points.h"

#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"

#include <algorithm>
#include <numeric>

namespace sinew {

namespace {
constexpr int lanes = BlendKernels::lanes;
}

PlacedPoints::PlacedPoints(const std::vector<LatticePlace>& places, int cells)
{
    // A counting sort keeps the order of the points within a cell, so that memory is read in that order.
    std::vector<int> ends(static_cast<std::size_t>(cells) + 1, 0);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const LatticePlace& place = places[i];
        if (place.weighted)
            weighted_.push_back({static_cast<int>(i), place.cell, place.weights});
        else
            ++ends[static_cast<std::size_t>(place.cell) + 1];
    }
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    std::vector<int> sorted(static_cast<std::size_t>(ends.back())), next(ends.begin(), ends.end() - 1);
    for (std::size_t i = 0; i < places.size(); ++i)
        if (!places[i].weighted)
            sorted[static_cast<std::size_t>(next[static_cast<std::size_t>(places[i].cell)]++)] =
                static_cast<int>(i);
    std::size_t blocks = 0;
    for (int cell = 0; cell < cells; ++cell)
        blocks += static_cast<std::size_t>(ends[cell + 1] - ends[cell] + lanes - 1) / lanes;
    blocks_.reserve(blocks);
    order_.reserve(blocks * lanes);
    local_.reserve(blocks * 3 * lanes);
    for (int cell = 0; cell < cells; ++cell)
        for (int from = ends[cell]; from < ends[cell + 1]; from += lanes) {
            const int count = std::min(lanes, ends[cell + 1] - from);
            blocks_.push_back({cell, count});
            for (int k = 0; k < lanes; ++k) // the last point fills the block
                order_.push_back(sorted[static_cast<std::size_t>(from + std::min(k, count - 1))]);
            for (int axis = 0; axis < 3; ++axis)
                for (int k = 0; k < lanes; ++k)
                    local_.push_back(
                        places[static_cast<std::size_t>(order_[order_.size() - lanes + k])].local[axis]);
        }
}

template <class Real>
void PlacedPoints::blend(const CellOf& cell_of, PointsView base, Real* positions) const
{
    const BlendKernels& kernels = widest_kernels<BlendKernels>();
    parallel_chunks(static_cast<int>(blocks_.size()), 512, [&](int begin, int end) {
        std::array<double, 3 * lanes> sums;
        BlendCell cell{};
        int known = -1;
        for (int b = begin; b < end; ++b) {
            const Block& block = blocks_[static_cast<std::size_t>(b)];
            if (block.cell != known)
                cell = cell_of(known = block.cell);
            kernels.blend(cell, local_.data() + static_cast<std::size_t>(b) * 3 * lanes, sums.data());
            const int* const points = order_.data() + static_cast<std::size_t>(b) * lanes;
            for (int k = 0; k < block.count; ++k) {
                const auto at = 3 * static_cast<std::size_t>(points[k]);
                for (int axis = 0; axis < 3; ++axis)
                    positions[at + axis] = static_cast<Real>(base.data()[at + axis] + sums[lanes * axis + k]);
            }
        }
    });
    parallel_for(static_cast<int>(weighted_.size()), [&](int i) {
        const Weighted& one = weighted_[static_cast<std::size_t>(i)];
        const double* const corners = cell_of(one.cell).moves;
        const auto at = 3 * static_cast<std::size_t>(one.point);
        for (int axis = 0; axis < 3; ++axis) {
            double sum = 0.0;
            for (int corner = 0; corner < 8; ++corner)
                sum += one.weights[corner] * corners[3 * corner + axis];
            positions[at + axis] = static_cast<Real>(base.data()[at + axis] + sum);
        }
    });
}

std::int64_t PlacedPoints::bytes() const
{
    return static_cast<std::int64_t>(blocks_.size() * sizeof(Block) + order_.size() * sizeof(int) +
                                     local_.size() * sizeof(double) + weighted_.size() * sizeof(Weighted));
}

template void PlacedPoints::blend(const CellOf&, PointsView, double*) const;
template void PlacedPoints::blend(const CellOf&, PointsView, float*) const;

} // namespace sinew
