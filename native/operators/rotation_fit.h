// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <Eigen/Geometry>

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
/// rank-deficient S; identity for S = 0. About 60 ns, 600 ns on the safe path.
Eigen::Quaterniond fit_rotation_quaternion(const Matrix3& S);

inline Matrix3 fit_rotation(const Matrix3& S) { return fit_rotation_quaternion(S).toRotationMatrix(); }

/// The same through a singular value decomposition: the reference, and the safe path.
Matrix3 fit_rotation_svd(const Matrix3& S);

/// Rotation by the vector's length (radians) about its direction.
Matrix3 rotation_from_vector(const Vector3& omega);

} // namespace sinew
