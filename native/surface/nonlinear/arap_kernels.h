// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// The two other corners of a triangle at a node, with half the cotangents opposite the
/// edges (node, b), (node, c) and (b, c): what the rims of a cell need.
struct ArapWing
{
    int b, c;
    double to_b, to_c, across;
};

/// What the loops over an ArapGraph read. Points hold four numbers a node, the last one zero; matrices hold
/// twelve, their three columns.
struct ArapView
{
    const int *offsets, *neighbours;
    const double *weights, *rigidity;
    const int* wing_offsets; ///< null: spokes only
    const ArapWing* wings;
    const int* place;        ///< row of the gradient, -1 for none
    const char* idle;
    const double *base, *points;
    double smoothing;
};

/// The loops of one evaluation over the nodes [begin, end). Every set of kernels does the same operations in
/// the same order, without fused ones: results agree to the last bit.
struct ArapKernels
{
    /// S_i = r_i sum over the cell's edges of w p e^T; that of `begin` comes first.
    void (*covariances)(const ArapView& view, int begin, int end, double* S);
    /// S_i += 2 alpha A sum_j r_ij w_ij R_j
    void (*add_neighbours)(const ArapView& view, const double* R, int begin, int end, double* S);
    /// t_i = vee(S_i R_i^T), three numbers each: how S_i pulls at R_i.
    void (*torques)(const double* S, const double* R, int count, double* t);
    /// to_i = turn(omega_i) R_i by Cayley's formula, |omega| cut to 1.
    void (*turn)(const double* omega, const double* R, int count, double* to);
    /// to_i = the rotation closest to S_i + tie |S_i| R_i; safe_i says where it was found.
    void (*fit)(const double* S, const double* R, double tie, int count, double* to, bool* safe);
    /// E of these nodes, and what of its gradient belongs to them.
    double (*energy)(const ArapView& view, const double* R, int begin, int end, double* gradient);
};

/// The widest kernels that this processor runs.
const ArapKernels& arap_kernels();

/// By name, for tests: the kernels every processor runs, and those with AVX2 (null where it has none).
const ArapKernels& baseline_arap_kernels();
const ArapKernels* avx2_arap_kernels();

} // namespace sinew
