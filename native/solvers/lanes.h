// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace sinew {

/// Right-hand sides solved side by side: x, y, z and one to spare.
constexpr int lane_count = 4;

/// A supernode of a Cholesky factor as SupernodalSolve prepares it: `values` is column-major, `height`
/// numbers a column, its first `width` rows the triangle of its own columns. In blocks of triangle_width
/// columns stands the inverse of each triangle: its diagonal in `diagonal`, its strict part transposed above
/// that of `values`. Seven numbers past a column are read and must be finite.
template <class T>
struct LaneSupernode
{
    static constexpr int triangle_width = 16;

    const T* values;
    const T* diagonal; ///< (width)
    const int* rows;   ///< (height - width) places of the rows below its own
    int width, height;

    /// Numbers of workspace that the kernels need.
    static constexpr std::size_t workspace(int height) { return 4 * (static_cast<std::size_t>(height) + 16); }
};

/// Loops over points of four lanes. T is double or float. Every set of kernels does the same operations in
/// the same order, without fused ones: results agree to the last bit.
template <class T>
struct LaneKernels
{
    /// own = L^-1 own for the (width) points of one supernode; the rows below take what these give them: row
    /// r < inside at points + 4 r, others at sums + 4 place[r]. `lanes`: 3 where the fourth is left alone, or
    /// 4.
    void (*forward)(const LaneSupernode<T>& s, int lanes, T* own, T* points, int inside, T* sums,
                    const int* place, T* workspace);
    /// own = L^-T own, given the rows below at points + 4 r.
    void (*backward)(const LaneSupernode<T>& s, int lanes, T* own, const T* points, T* workspace);
    /// sums (8, 3) = start (8, 3) + matrix (8, columns) * factors (columns, 3). `block` holds start and then
    /// matrix, `sums` the same shape as start, all column-major; factors is row-major.
    void (*product_of_eight)(const T* block, int columns, const T* factors, T* sums);
};

/// The widest kernels that this processor runs.
template <class T>
const LaneKernels<T>& lane_kernels();

/// By name, for tests: the kernels every processor runs, and those with AVX2 (null where it has none).
template <class T>
const LaneKernels<T>& baseline_lane_kernels();
template <class T>
const LaneKernels<T>* avx2_lane_kernels();

} // namespace sinew
