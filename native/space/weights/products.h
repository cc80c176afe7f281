// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// Products of the weights of points with moves. They wait for memory: more than four lanes gain nothing.
/// Every variant does the same operations in the same order, without fused ones: results agree to the last
/// bit.
struct ProductKernels
{
    /// sums (3, points per block) = block * factors (columns, 3); a block holds one column of its points
    /// after the other: 8 doubles or 16 floats.
    void (*product_of_doubles)(const double* block, int columns, const double* factors, double* sums);
    void (*product_of_floats)(const float* block, int columns, const float* factors, float* sums);
    /// sums (rows, 4) = weights * factors (columns, 4); row i of the weights is [offsets[i], offsets[i + 1]).
    void (*sparse_product_of_doubles)(const double* weights, const int* columns, const int* offsets, int rows,
                                      const double* factors, double* sums);
    void (*sparse_product_of_floats)(const float* weights, const int* columns, const int* offsets, int rows,
                                     const float* factors, float* sums);

    static const ProductKernels baseline, avx2;
};

} // namespace sinew
