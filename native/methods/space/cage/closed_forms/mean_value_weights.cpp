// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/closed_forms/mean_value_weights.h"

#include "native/core/simd/aligned.h"
#include "native/core/simd/kernel_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace sinew {

void mean_value_weights(const CageGeometry& geometry, PointsView block, RowMatrix& rows,
                        std::vector<char>& outside)
{
    const CageTables tables = geometry.tables();
    const CageKernels& kernels = widest_kernels<CageKernels>();
    const int vertices = tables.vertex_count, count = static_cast<int>(block.rows()), lanes = kernels.lanes;
    AlignedVector<double> scratch(geometry.scratch_size(kernels));
    AlignedVector<double> weights(static_cast<std::size_t>(lanes) * static_cast<std::size_t>(vertices));
    rows.resize(count, vertices);
    outside.assign(static_cast<std::size_t>(count), 0);
    for (int first = 0; first < count; first += lanes) {
        std::array<Vector3, most_cage_lanes> x;
        PointLanes points(kernels);
        for (int lane = 0; lane < lanes; ++lane) {
            x[lane] =
                geometry.within_reach(geometry.normalized(block.row(std::min(first + lane, count - 1))));
            points.set(lane, x[lane]);
        }
        std::array<int, most_cage_lanes> on;
        std::array<double, most_cage_lanes> sums;
        kernels.mean_value(tables, points.lanes, scratch.data(), weights.data(), sums.data(), on.data());
        for (int lane = 0; lane < std::min(lanes, count - first); ++lane) {
            double* const row = rows.row(first + lane).data();
            for (int v = 0; v < vertices; ++v)
                row[v] = weights[static_cast<std::size_t>(lanes) * static_cast<std::size_t>(v) + lane];
            const bool on_face = on[lane] >= 0, balanced = !(std::abs(sums[lane]) > 1e-13);
            if (on_face || balanced)
                std::fill(row, row + vertices, 0.0);
            if (on_face) {
                const Vector3 shares = geometry.barycentric(on[lane], x[lane]);
                for (int k = 0; k < 3; ++k)
                    row[tables.triangles[on[lane]].corners[k]] = shares[k];
            }
            // A ray from a point outside first enters the cage and then leaves it, and so on. Nearer
            // crossings have larger weights, so the sum is negative.
            outside[static_cast<std::size_t>(first + lane)] = !on_face && !(sums[lane] > 0.0);
        }
    }
}

} // namespace sinew
