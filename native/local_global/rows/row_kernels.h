// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/local_global/arap/arap_kernels.h"

namespace sinew {

/// What the kernels read of RowSystem. Points and vectors have three numbers each and rotations nine,
/// column after column; the kernels may read one number past the end of each array.
struct RowView
{
    /// The rows whose first rotation is that of group g are [rows[g], rows[g + 1]); those of a table without
    /// pairs are all of its rows.
    const int* rows;
    const int* terms; ///< row k has the terms [terms[k], terms[k + 1])
    const int* term_points;
    const double* coefficients;
    const double* weights; ///< one per row
    const double* vectors; ///< one per row; with pairs two, u and v
    const int* row_groups; ///< only with pairs: two per row, or -1 for the second
    /// Only with pairs: group g is number 0 or 1 of a row k where turns[first_turns[g]] ... = 2 k or 2 k + 1.
    const int *first_turns, *turns;
    /// The parts of the gradient at free point i are [parts[i], parts[i + 1]): shares of forces.
    const int *parts, *part_forces;
    const double* part_shares;
    /// Only for cells of four points: four points and the six entries M_11, M_12, M_13, M_22, M_23, M_33 of
    /// each group's matrix.
    const int* corners;
    const double* matrices;
    const double *base, *points;
};

/// The loops of one evaluation. Every variant does the same operations in the same order and fuses none, so
/// results agree to the last bit. Where a chunk of groups is asked for, S and t begin with its first group;
/// S has the layout of ArapKernels.
struct RowKernels
{
    /// Without pairs, for the rows k of groups [begin, end): r_k = sum_i c_ki x_i, and
    /// S_g = sum_k w_k r_k u_k^T.
    void (*stretches)(const RowView& view, int begin, int end, double* r, double* S);
    /// r_k becomes the force w_k (r_k - R_g u_k). \return the sum of w_k |r_k - R_g u_k|^2
    double (*forces)(const RowView& view, int begin, int end, const double* R, double* r);

    /// With pairs, for rows [begin, end): r_k = sum_i c_ki x_i - R_a u_k - R_b v_k
    void (*residuals)(const RowView& view, int begin, int end, const double* R, double* r);
    /// t_g = sum over a group's rows of w (R_g u) x r
    void (*torques)(const RowView& view, int begin, int end, const double* R, const double* r, double* t);
    /// S_g = sum over a group's rows of w (r + R_g u) u^T
    void (*covariances)(const RowView& view, int begin, int end, const double* R, const double* r, double* S);
    /// r_k becomes the force w_k r_k. \return the sum of w_k |r_k|^2
    double (*weigh)(const RowView& view, int begin, int end, double* r);

    /// For cells of four points, with y_a = x_a - x_0 and z_a likewise of the base: S_g = sum_ab M_ab y_a
    /// z_b^T
    void (*cell_covariances)(const RowView& view, int begin, int end, double* S);
    /// Four forces per group: f_a = sum_b M_ab (y_b - R z_b), and f_0 against all of them.
    /// \return the sum of f_a . (y_a - R z_a)
    double (*cell_forces)(const RowView& view, int begin, int end, const double* R, double* f);

    /// The gradient of free points [begin, end): the sum of their parts.
    void (*gather)(const RowView& view, int begin, int end, const double* forces, double* gradient);

    static const RowKernels baseline, avx2;
};

} // namespace sinew
