// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/cell_fits.h"

#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/operators/fits/rotation_fit.h"

namespace sinew {

void fit_cells(const double* S, const double* R, double tie, int count, double* to)
{
    bool safe[graph_chunk];
    widest_kernels<ArapKernels>().fit(S, R, tie, count, to, safe);
    for (int i = 0; i < count; ++i) {
        if (safe[i])
            continue;
        const std::size_t first = entries * static_cast<std::size_t>(i);
        const Matrix3 own = covariance(S, i);
        const Matrix3 last = Eigen::Map<const Matrix3>(R + first);
        Eigen::Map<Matrix3>(to + first) = fit_rotation_svd(own + tie * own.norm() * last);
    }
}

void pack(const PointsView& points, std::vector<double>& packed)
{
    packed.resize(points.size() + 1);
    parallel_for(static_cast<int>(points.rows()), [&](int i) {
        for (int k = 0; k < 3; ++k)
            packed[3 * static_cast<std::size_t>(i) + k] = points(i, k);
    });
}

} // namespace sinew
