// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/symmetric.h"

#include <Eigen/Eigenvalues>

namespace sinew {

namespace {

template <class Matrix>
Eigenvectors<Matrix::RowsAtCompileTime> found(const Matrix& symmetric)
{
    const Eigen::SelfAdjointEigenSolver<Matrix> eigen(symmetric);
    return {eigen.eigenvalues(), eigen.eigenvectors()};
}

} // namespace

Eigenvectors<3> eigenvectors(const Eigen::Matrix3d& symmetric) { return found(symmetric); }

Eigenvectors<4> eigenvectors(const Eigen::Matrix4d& symmetric) { return found(symmetric); }

} // namespace sinew
