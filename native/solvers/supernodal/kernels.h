// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace sinew {

/// Number of right-hand sides that are solved together: x, y, z and one that may be unused.
constexpr int lane_count = 4;

/// A supernode of a Cholesky factor as SupernodalSolve prepares it. `values` is column-major with `height`
/// numbers per column; the first `width` rows are the triangle of its own columns. This triangle is divided
/// into blocks of triangle_width columns, and the inverse of each block's triangle is stored: its diagonal in
/// `diagonal`, its strict part transposed above the diagonal of `values`. Kernels read seven numbers past a
/// column, which must be finite.
template <class T>
struct LaneSupernode
{
    static constexpr int triangle_width = 16;

    const T* values;
    const T* diagonal; ///< (width)
    const int* rows;   ///< (height - width) the positions of the rows below its own
    int width, height;

    /// Size of the workspace that the kernels need.
    static constexpr std::size_t workspace(int height) { return 4 * (static_cast<std::size_t>(height) + 16); }
};

/// Loops over points of four lanes. T is double or float. Every variant does the same operations in the same
/// order and fuses none, so results agree to the last bit.
template <class T>
struct LaneKernels
{
    /// own = L^-1 own for the (width) points of one supernode. Subtracts their contributions from the rows
    /// below: for row r < inside at points + 4 r, for others at sums + 4 place[r]. `lanes` is 4, or 3 to
    /// leave the fourth lane as it is.
    void (*forward)(const LaneSupernode<T>& s, int lanes, T* own, T* points, int inside, T* sums,
                    const int* place, T* workspace);
    /// own = L^-T own, where row r below is at points + 4 r.
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
