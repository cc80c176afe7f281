// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/lattice/grid/placed_points.h"

#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"

#include <algorithm>
#include <cstddef>

namespace sinew {

namespace {
constexpr int lanes = BlendKernels::lanes;
}

PlacedPoints::PlacedPoints(const std::vector<LatticePlace>& places, int cells)
{
    const int count = static_cast<int>(places.size());
    std::vector<char> used(static_cast<std::size_t>(cells), 0);
    for (const LatticePlace& place : places)
        used[static_cast<std::size_t>(place.cell)] = 1;
    // Points are sorted by cells within stretches of the whole, so that those of a stretch stay in the cache;
    // long ones for many cells, so that most blocks are full.
    const auto filled = static_cast<int>(std::count(used.begin(), used.end(), 1));
    const int stretch = std::max(8192, 64 * std::min(filled, 1 << 20));
    const int stretches = (count + stretch - 1) / stretch;
    std::vector<std::vector<int>> sorted(static_cast<std::size_t>(stretches));
    parallel_tasks(stretches, [&](int s) {
        std::vector<int>& own = sorted[static_cast<std::size_t>(s)];
        for (int i = s * stretch; i < std::min(count, (s + 1) * stretch); ++i)
            if (!places[static_cast<std::size_t>(i)].weighted)
                own.push_back(i);
        std::stable_sort(own.begin(), own.end(), [&](int a, int b) {
            return places[static_cast<std::size_t>(a)].cell < places[static_cast<std::size_t>(b)].cell;
        });
    });
    for (int i = 0; i < count; ++i)
        if (const LatticePlace& place = places[static_cast<std::size_t>(i)]; place.weighted)
            weighted_.push_back({i, place.cell, place.weights});
    std::vector<int> begins; // of the blocks of each stretch
    for (const std::vector<int>& own : sorted) {
        begins.push_back(static_cast<int>(blocks_.size()));
        for (std::size_t from = 0; from < own.size();) {
            const int cell = places[static_cast<std::size_t>(own[from])].cell;
            std::size_t end = from;
            while (end < own.size() && end < from + lanes &&
                   places[static_cast<std::size_t>(own[end])].cell == cell)
                ++end;
            blocks_.push_back({cell, static_cast<int>(end - from)});
            from = end;
        }
    }
    order_.resize(blocks_.size() * lanes);
    local_.resize(blocks_.size() * 3 * lanes);
    parallel_tasks(stretches, [&](int s) {
        const std::vector<int>& own = sorted[static_cast<std::size_t>(s)];
        std::size_t from = 0;
        for (auto b = static_cast<std::size_t>(begins[static_cast<std::size_t>(s)]); from < own.size(); ++b) {
            const auto held = static_cast<std::size_t>(blocks_[b].count);
            for (std::size_t k = 0; k < lanes; ++k) { // the last point fills the block
                const int point = own[from + std::min(k, held - 1)];
                order_[b * lanes + k] = point;
                for (int axis = 0; axis < 3; ++axis)
                    local_[(b * 3 + static_cast<std::size_t>(axis)) * lanes + k] =
                        places[static_cast<std::size_t>(point)].local[axis];
            }
            from += held;
        }
    });
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
