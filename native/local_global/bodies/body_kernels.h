// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/local_global/arap/arap_kernels.h"

namespace sinew {

/// What the kernels read of RigidBodies. Points have three numbers each and rotations nine, column after
/// column; the kernels may read one number past the end of either.
struct BodyView
{
    /// The joints of free body i with later bodies of its chunk begin at first[2 i], those with all others at
    /// first[2 i + 1]; they end at first[2 i + 2]. `others` has the other body of each joint.
    const int *first, *others;
    const double* joints; ///< joint_numbers each: p of body i, q of the other, the six of B, w
    int free;             ///< bodies [0, free) move
    const double* points;
};

constexpr int joint_numbers = 13;

/// The loops of one evaluation over the free bodies [begin, end) of a chunk. Every variant does the same
/// operations in the same order and fuses none, so results agree to the last bit. S, t and gradient begin
/// with the first body of the chunk; S has the layout of ArapKernels.
struct BodyKernels
{
    /// S_i = sum over the joints of body i of w (t_j + R_j q - t_i) p^T + R_j B
    void (*covariances)(const BodyView& view, int begin, int end, const double* R, double* S);
    /// t_i = sum over the columns of R_i x S_i: how strongly its joints turn body i.
    void (*torques)(const double* S, const double* R, int count, double* t);
    /// The gradient with respect to t_i, three numbers each.
    /// \return twice the energy of the joints, half of it for a joint that another chunk has, too.
    double (*energy)(const BodyView& view, int begin, int end, const double* R, double* gradient);

    static const BodyKernels baseline, avx2;
};

} // namespace sinew
