// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/solvers/systems/linear_solver.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace sinew {

constexpr int most_dense = 5000; ///< unknowns of a dense solver: 200 MB

/// The size of a factor.
struct DirectNumbers
{
    std::int64_t entries = 0, bytes = 0;
};

/// Factorises A by one of the direct solvers, and gives what solves for any number of columns.
/// \param order  of elimination, for the sparse Cholesky factors.
/// \throw FactorizationFailed  A is singular, or not positive definite and the solver needs that.
/// \throw OutOfMemory
std::function<RowMatrix(const RowMatrix&)> factorized(const SparseMatrix& A, Solver solver,
                                                      std::vector<int> order, DirectNumbers& numbers);

} // namespace sinew
