// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// One piece of the functions along an axis, see AxisBasis.
struct BlendAxis
{
    const double* coefficients; ///< (width, degree + 1)
    int width, degree;
};

/// The part of a lattice that moves the points of one cell.
struct BlendCell
{
    BlendAxis axes[3];
    const double* moves; ///< (3) of the first control point; those along the first axis follow each other
    int strides[2];      ///< numbers from a row of control points to the next, and from a layer to the next
};

/// Blends the moves of control points for eight points of the same cell at a time. Every variant does the
/// same operations in the same order and fuses none, so results agree to the last bit.
struct BlendKernels
{
    static constexpr int lanes = 8;
    static constexpr int most_width = 16;

    /// sums (3, lanes) = sum_ijk B_i(u) B_j(v) B_k(w) moves_ijk
    /// \param local  (3, lanes) u, v and w in the cell
    void (*blend)(const BlendCell& cell, const double* local, double* sums);

    static const BlendKernels baseline, avx2, avx512;
};

} // namespace sinew
