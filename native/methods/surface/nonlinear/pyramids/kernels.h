// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// What the kernels read of PyramidCells. Points and vectors have three numbers each; the kernels may read
/// one number past the end of each array.
struct PyramidView
{
    const int* offsets; ///< cell i has the directed edges [offsets[i], offsets[i + 1])
    const int* ends;    ///< the point at the other end of each directed edge
    const int* backs;   ///< the directed edge that runs back, or -1 where that belongs to no cell
    const double* shares; ///< w_ij, one per directed edge
    const double* sides;  ///< c_i, one per cell
    const double* stiffness; ///< k_i, one per cell
    const double* edges; ///< e_ij of the shape to be kept
    const double* tips;  ///< d_i of the shape to be kept
    const double* points;
};

/// The loops of one evaluation over cells [begin, end). Every variant does the same operations in the same
/// order and fuses none, so results agree to the last bit.
struct PyramidKernels
{
    /// S_i = c_i sum_j y_ij e_ij^T + k_i z_i d_i^T, with the present edges y and tips z. S begins with that
    /// of the first cell and has the layout of ArapKernels.
    void (*covariances)(const PyramidView& view, int begin, int end, double* S);
    /// One force per directed edge, which acts on its end, and minus their sum for each cell.
    /// \param R  nine numbers per cell, column after column.
    /// \return twice the energy of these cells.
    double (*forces)(const PyramidView& view, int begin, int end, const double* R, double* forces,
                     double* sums);
    /// The gradient at points [begin, end).
    void (*gather)(const PyramidView& view, int begin, int end, const double* forces, const double* sums,
                   double* gradient);

    static const PyramidKernels baseline, avx2;
};

} // namespace sinew
