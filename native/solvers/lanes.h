// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// Right-hand sides solved side by side: x, y, z and one to spare.
constexpr int lane_count = 4;

/// Products of a dense block with points of four lanes. `block` is column-major with leading dimension
/// `stride`; `points` and `rows` hold four numbers an entry. T is double or float. Every set of kernels does
/// the same operations in the same order, without fused ones: results agree to the last bit.
template <class T>
struct LaneKernels
{
    /// rows -= block * points
    void (*subtract_product)(const T* block, int stride, int columns, int height, const T* points, T* rows);
    /// points -= block^T * rows
    void (*subtract_transposed)(const T* block, int stride, int columns, int height, const T* rows,
                                T* points);
    /// points = T * points, T lower triangular; its strict part stands transposed in the upper triangle
    /// of `block`, its diagonal in `diagonal`.
    void (*triangle)(const T* block, int stride, int columns, const T* diagonal, T* points);
    /// points = T^T * points
    void (*triangle_transposed)(const T* block, int stride, int columns, const T* diagonal, T* points);
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
