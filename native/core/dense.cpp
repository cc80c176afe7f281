// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/dense.h"

#include <Eigen/Eigenvalues>

#include <cmath>

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

Vector3 solve_symmetric(const Matrix3& A, const Vector3& b) { return A.ldlt().solve(b); }

Eigen::Vector2d solve_symmetric(const Eigen::Matrix2d& A, const Eigen::Vector2d& b)
{
    return A.ldlt().solve(b);
}

bool CholeskyFactor::factorize(const MatrixX& A)
{
    factor_.compute(A);
    return factor_.info() == Eigen::Success;
}

VectorX CholeskyFactor::solve(const VectorX& b) const { return factor_.solve(b); }

MatrixX CholeskyFactor::solve(const MatrixX& B) const { return factor_.solve(B); }

Points CholeskyFactor::solve(const Points& B) const { return factor_.solve(B); }

void LeastNorm::factorize(const MatrixX& A, double threshold)
{
    if (threshold > 0)
        factor_.setThreshold(threshold);
    factor_.compute(A);
}

VectorX LeastNorm::solve(const VectorX& b) const { return factor_.solve(b); }

VectorX times(const MatrixX& A, const VectorX& x) { return A * x; }

MatrixX product(const MatrixX& A, const MatrixX& B) { return A * B; }

VectorX transposed_times(const MatrixX& A, const VectorX& x) { return A.transpose() * x; }

MatrixX transposed_product(const MatrixX& A, const MatrixX& B) { return A.transpose() * B; }

Eigen::Quaterniond smallest_turn(const Vector3& from, const Vector3& to)
{
    const Vector3 a = from.normalized(), b = to.normalized();
    const double cosine = b.dot(a);
    Eigen::Quaterniond turn;
    if (cosine < -1.0 + 1e-12) { // opposite
        turn.w() = 0.0;
        turn.vec() = a.unitOrthogonal();
    } else {
        const double twice = std::sqrt((1.0 + cosine) * 2.0);
        turn.w() = 0.5 * twice;
        turn.vec() = a.cross(b) * (1.0 / twice);
    }
    return turn;
}

} // namespace sinew
