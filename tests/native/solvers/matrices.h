// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "tests/native/shapes.h"

/// Sparse matrices that the solver tests share.
namespace sinew::matrices {

/// Five-point Laplacian plus `shift` times the identity on a square grid, its unknowns shuffled.
SparseMatrix shuffled_grid(int side, double shift = 0.01);

/// The points of its unknowns, a unit apart.
Points points_of_shuffled_grid(int side);

/// Symmetric positive definite with a random pattern; eigenvalues of at least 0.5.
SparseMatrix random_spd(int n, int seed, int entries_per_row = 4);

SparseMatrix diagonal(const std::vector<double>& values);

} // namespace sinew::matrices
