// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/native/dense.h"

#include "tests/native/shapes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <Eigen/SparseCholesky>

namespace sinew::dense {

MatrixX product(const MatrixX& A, const MatrixX& B) { return A * B; }

MatrixX solution(const MatrixX& A, const MatrixX& b) { return A.fullPivLu().solve(b); }

MatrixX solution(const SparseMatrix& A, const MatrixX& b)
{
    return Eigen::SimplicialLDLT<SparseMatrix>(A).solve(b);
}

MatrixX solution(const MatrixX& A, const MatrixX& b, MatrixX x, const std::vector<int>& free)
{
    for (int row : free)
        x.row(row).setZero();
    const MatrixX rhs = (b - A * x)(free, Eigen::all);
    x(free, Eigen::all) = solution(A(free, free), rhs);
    return x;
}

MatrixX random_definite(int size, int seed, double least)
{
    const MatrixX B = shapes::Random(static_cast<std::uint64_t>(seed)).dense(size, size);
    return B * B.transpose() + least * MatrixX::Identity(size, size);
}

VectorX eigenvalues(const MatrixX& symmetric)
{
    return Eigen::SelfAdjointEigenSolver<MatrixX>(symmetric, Eigen::EigenvaluesOnly).eigenvalues();
}

MatrixX eigenvectors(const MatrixX& symmetric)
{
    return Eigen::SelfAdjointEigenSolver<MatrixX>(symmetric).eigenvectors();
}

Matrix3 rotation_of(const Matrix3& S)
{
    const Eigen::JacobiSVD<Matrix3> svd(S, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Vector3 sign(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
    return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

double largest(const MatrixX& matrix) { return matrix.cwiseAbs().maxCoeff(); }

MatrixX with_positive_weights(const MatrixX& L)
{
    MatrixX found = L.unaryExpr([](double entry) { return entry > 1e-9 ? -1e-6 * entry : entry; });
    found.diagonal().setZero();
    found.diagonal() = -found.rowwise().sum().eval();
    return found;
}

} // namespace sinew::dense
