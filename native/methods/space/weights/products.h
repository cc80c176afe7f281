// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// Products of the weights of points with moves. Memory limits their speed, so eight lanes would not be
/// faster than four. Every variant does the same operations in the same order and fuses none, so results
/// agree to the last bit.
struct ProductKernels
{
    /// sums (3, points per block) = block * factors (columns, 3). A block has the weights of 8 points in
    /// double precision or of 16 in single precision, one column after the other.
    void (*product_of_doubles)(const double* block, int columns, const double* factors, double* sums);
    void (*product_of_floats)(const float* block, int columns, const float* factors, float* sums);
    /// sums (rows, 4) = weights * factors (columns, 4). Row i of the weights is [offsets[i], offsets[i + 1]).
    void (*sparse_product_of_doubles)(const double* weights, const int* columns, const int* offsets, int rows,
                                      const double* factors, double* sums);
    void (*sparse_product_of_floats)(const float* weights, const int* columns, const int* offsets, int rows,
                                     const float* factors, float* sums);

    static const ProductKernels baseline, avx2;
};

} // namespace sinew
