// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <vector>

/// Dense matrices for oracles. Eigen's factorisations and products take seconds to compile, so that one source has them.
namespace sinew::dense {

/// A B.
MatrixX product(const MatrixX& A, const MatrixX& B);

/// x of A x = b, by an LU factorisation with full pivoting.
MatrixX solution(const MatrixX& A, const MatrixX& b);

/// x of A x = b with a symmetric A, by Eigen's factor L D L^T.
MatrixX solution(const SparseMatrix& A, const MatrixX& b);

/// x whose rows of `free` fulfil A x = b; the others stay.
MatrixX solution(const MatrixX& A, const MatrixX& b, MatrixX x, const std::vector<int>& free);

/// B B^T + least I, with random entries in B.
MatrixX random_definite(int size, int seed, double least = 1.0);

/// The eigenvalues of a symmetric matrix, smallest first.
VectorX eigenvalues(const MatrixX& symmetric);

/// The eigenvectors of a symmetric matrix as columns, that of the smallest eigenvalue first.
MatrixX eigenvectors(const MatrixX& symmetric);

/// The rotation R of the largest trace(R^T S), by singular values.
Matrix3 rotation_of(const Matrix3& S);

double largest(const MatrixX& matrix);

/// A Laplacian whose negative weights became positive ones of a millionth of their size.
MatrixX with_positive_weights(const MatrixX& L);

} // namespace sinew::dense
