// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

namespace sinew {

/// The rotation R (det +1) that maximises trace(R^T S), the closest to S [Hor87].
///
/// B. K. P. Horn. "Closed-form solution of absolute orientation using unit quaternions."
/// JOSA A 4(4), 1987.
///
/// The quaternion of R belongs to the largest eigenvalue of a symmetric 4x4 matrix, found by
/// Newton's iteration on its characteristic polynomial from above. Where that eigenvalue is
/// nearly double (S of rank one, or reflected with two equal smaller singular values) the
/// iteration would lose digits, and a double SVD takes over. Exact for reflected and
/// rank-deficient S; identity for S = 0. Some 30 ns where four run side by side (rotation_fit.inl),
/// 600 ns on the safe path.
Matrix3 fit_rotation(const Matrix3& S);

/// The same through a singular value decomposition: the reference, and the safe path.
Matrix3 fit_rotation_svd(const Matrix3& S);

} // namespace sinew
