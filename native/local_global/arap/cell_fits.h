// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/local_global/arap/arap_kernels.h"

#include <cstddef>
#include <vector>

namespace sinew {

/// A cell whose edges lie on one line says nothing about the rotation around that line. Therefore this share
/// of its former rotation is added. At the minimum, where rotations no longer change, it has no effect.
constexpr double tie = 1e-8;

constexpr int entries = 9; ///< of a rotation, column after column
constexpr std::size_t chunk_numbers = covariance_columns * (graph_chunk + 1); ///< covariances of a chunk

/// The covariance of the i-th cell of a chunk, as the kernels store it.
inline auto covariance(const double* S, int i)
{
    using Lanes = Eigen::Map<const Matrix3, 0, Eigen::OuterStride<covariance_columns / 3>>;
    return Lanes(S + covariance_columns * static_cast<std::size_t>(i));
}

/// to_i = the rotation closest to S_i + tie |S_i| R_i, for the `count` cells of a chunk; `to` may be R.
void fit_cells(const double* S, const double* R, double tie, int count, double* to);

/// Three numbers per point, and one more at the end that kernels may read.
void pack(const PointsView& points, std::vector<double>& packed);

} // namespace sinew
