// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <Eigen/Geometry>

/// What Eigen's decompositions of dense matrices give that take 7 to 9 seconds to compile: one source has
/// them.
namespace sinew {

/// The eigenvalues of a symmetric matrix, smallest first, and an orthonormal eigenvector of each, as a
/// column.
template <int size>
struct Eigenvectors
{
    Eigen::Matrix<double, size, 1> values;
    Eigen::Matrix<double, size, size> vectors;
};

// Only the lower triangle is read.
Eigenvectors<3> eigenvectors(const Eigen::Matrix3d& symmetric);
Eigenvectors<4> eigenvectors(const Eigen::Matrix4d& symmetric);
Eigenvectors<Eigen::Dynamic> eigenvectors(const MatrixX& symmetric);

/// The smallest turn that takes one direction to another; for opposite ones, any of them. Neither may be
/// zero.
Eigen::Quaterniond smallest_turn(const Vector3& from, const Vector3& to);

} // namespace sinew
