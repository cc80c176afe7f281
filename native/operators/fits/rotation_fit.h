// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

namespace sinew {

/// The rotation R (det +1) that maximises trace(R^T S): the rotation closest to S.
///
/// B. K. P. Horn. "Closed-form solution of absolute orientation using unit quaternions."
/// JOSA A 4(4), 1987.
///
/// The quaternion of R is an eigenvector of a symmetric 4x4 matrix, that of its largest eigenvalue, which
/// Newton's iteration on the characteristic polynomial finds from above. Where that eigenvalue is nearly a
/// double one (S has rank one, or is reflected with two equal smaller singular values) the iteration would
/// lose digits, and fit_rotation_svd() takes over. Exact for reflected and rank-deficient S; the identity for
/// S = 0. Cost: some 30 ns where four fits run side by side (rotation_fit.inl), 600 ns by fit_rotation_svd().
Matrix3 fit_rotation(const Matrix3& S);

/// The same by a singular value decomposition in double precision: slower, but safe for every S.
Matrix3 fit_rotation_svd(const Matrix3& S);

} // namespace sinew
