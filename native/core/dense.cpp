// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/dense.h"

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

Eigenvectors<Eigen::Dynamic> eigenvectors(const MatrixX& symmetric) { return found(symmetric); }

Eigen::Quaterniond smallest_turn(const Vector3& from, const Vector3& to)
{
    return Eigen::Quaterniond::FromTwoVectors(from, to); // for opposite ones by singular values
}

} // namespace sinew
