// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// Multiply rows [begin, end) of a sparse matrix by points. A point has four numbers, of which the last is
/// unused; a row of the result has three. Every variant does the same operations in the same order and fuses
/// none, so results agree to the last bit.
struct StencilKernels
{
    void (*in_double)(const int* offsets, const int* indices, const double* weights, const double* points,
                      int begin, int end, double* to);
    void (*in_float)(const int* offsets, const int* indices, const float* weights, const float* points,
                     int begin, int end, float* to);

    static const StencilKernels baseline, avx2;
};

} // namespace sinew
