// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// Rows [begin, end) of a sparse matrix times points of four numbers each, the last one unused; three numbers
/// a row come out. Every variant does the same operations in the same order, without fused ones.
struct StencilKernels
{
    void (*in_double)(const int* offsets, const int* indices, const double* weights, const double* points,
                      int begin, int end, double* to);
    void (*in_float)(const int* offsets, const int* indices, const float* weights, const float* points,
                     int begin, int end, float* to);

    static const StencilKernels baseline, avx2;
};

} // namespace sinew
