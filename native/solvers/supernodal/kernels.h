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

/// Loops over points of four lanes. T is double or float. Every variant does the same operations in
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

    static const LaneKernels baseline, avx2;
};

template <>
const LaneKernels<double> LaneKernels<double>::baseline;
template <>
const LaneKernels<double> LaneKernels<double>::avx2;
template <>
const LaneKernels<float> LaneKernels<float>::baseline;
template <>
const LaneKernels<float> LaneKernels<float>::avx2;

} // namespace sinew
