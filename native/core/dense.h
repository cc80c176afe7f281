// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/QR>

/// Eigen's decompositions and products of dense matrices, which take 2 to 9 seconds each to compile: one
/// source has them.
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

/// The solution x of A x = b for a symmetric, positive semidefinite A, by LDL^T with pivots.
Vector3 solve_symmetric(const Matrix3& A, const Vector3& b);
Eigen::Vector2d solve_symmetric(const Eigen::Matrix2d& A, const Eigen::Vector2d& b);

/// The factor L of a symmetric, positive definite matrix A = L L^T.
class CholeskyFactor
{
public:
    /// \return false where A is not positive definite.
    [[nodiscard]] bool factorize(const MatrixX& A);
    VectorX solve(const VectorX& b) const;
    MatrixX solve(const MatrixX& B) const;
    Points solve(const Points& B) const;

private:
    Eigen::LLT<MatrixX> factor_;
};

/// The shortest x that minimises |A x - b|, of a matrix A of any rank.
class LeastNorm
{
public:
    /// \param threshold  pivots below this share of the largest one count as zero; 0 for what rounding asks
    ///   for.
    void factorize(const MatrixX& A, double threshold = 0.0);
    VectorX solve(const VectorX& b) const;
    int rank() const { return static_cast<int>(factor_.rank()); }
    /// The k-th column by what it adds to those before.
    int column(int k) const { return static_cast<int>(factor_.colsPermutation().indices()[k]); }

private:
    Eigen::CompleteOrthogonalDecomposition<MatrixX> factor_;
};

VectorX times(const MatrixX& A, const VectorX& x);            ///< A x
MatrixX product(const MatrixX& A, const MatrixX& B);            ///< A B
VectorX transposed_times(const MatrixX& A, const VectorX& x); ///< A^T x
MatrixX transposed_product(const MatrixX& A, const MatrixX& B); ///< A^T B

/// The smallest turn that takes one direction to another; for opposite ones, any of them. Neither may be
/// zero.
Eigen::Quaterniond smallest_turn(const Vector3& from, const Vector3& to);

} // namespace sinew
