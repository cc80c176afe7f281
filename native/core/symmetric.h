// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

namespace sinew {

/// The eigenvalues of a symmetric matrix, smallest first, and an orthonormal eigenvector of each, as a
/// column.
template <int size>
struct Eigenvectors
{
    Eigen::Matrix<double, size, 1> values;
    Eigen::Matrix<double, size, size> vectors;
};

// Only the lower triangle is read. Eigen's solver takes seconds to compile, so that one source has it.
Eigenvectors<3> eigenvectors(const Eigen::Matrix3d& symmetric);
Eigenvectors<4> eigenvectors(const Eigen::Matrix4d& symmetric);

} // namespace sinew
