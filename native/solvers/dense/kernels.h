// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// Columns of a packed strip.
constexpr int strip_width = 8;

/// Products of dense row-major blocks of doubles. Every variant does the same operations in the same order
/// and fuses none, so results agree to the last bit.
struct DenseKernels
{
    /// c (rows, strips * strip_width) += a (rows, inner) * b. Rows of `a` are stride_a apart, and its columns
    /// step_a. `b` is packed strip after strip, (inner, strip_width) each. Row r of the product is added to
    /// row place[r] of c, or to row r if `place` is null.
    void (*add_product)(const double* a, int stride_a, int step_a, int rows, int inner, const double* b,
                        int strips, double* c, int stride_c, const int* place);
    /// x (rows, strips * strip_width) = U^-T x, by substitution. U (rows, rows) is upper triangular; below
    /// its diagonal, anything may stand.
    void (*substitute)(const double* u, int stride_u, int rows, double* x, int stride_x, int strips);

    static const DenseKernels baseline, avx2, avx512;
};

} // namespace sinew
