// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/solvers/linear_system.h"
#include "native/solvers/orderings.h"

#include <cstdint>
#include <string>

namespace sinew {

/// Solvers of appendix A of the tutorial.
///
///   automatic           cholesky; lu where the matrix is not symmetric; multigrid where the factor needs more memory
///                       than limit_memory() allows, and the system has nodes
///   cholesky            sparse, with a dense block for each supernode
///   simplicial          sparse Cholesky, one column at a time
///   lu                  sparse, for matrices that are not symmetric
///   conjugate_gradients iterative, in little memory
///   multigrid           conjugate gradients with a cycle on a hierarchy of coarser graphs: for what has no factor, and
///                       for what is solved once
///   dense_cholesky, dense_lu, dense_qr, dense_svd   for at most 5000 unknowns
enum class Solver {
    automatic,
    cholesky,
    simplicial,
    lu,
    conjugate_gradients,
    multigrid,
    dense_cholesky,
    dense_lu,
    dense_qr,
    dense_svd
};
constexpr auto choices(Solver)
{
    return std::array{Choice{"automatic", Solver::automatic},
                      Choice{"cholesky", Solver::cholesky},
                      Choice{"simplicial", Solver::simplicial},
                      Choice{"lu", Solver::lu},
                      Choice{"conjugate_gradients", Solver::conjugate_gradients},
                      Choice{"multigrid", Solver::multigrid},
                      Choice{"dense_cholesky", Solver::dense_cholesky},
                      Choice{"dense_lu", Solver::dense_lu},
                      Choice{"dense_qr", Solver::dense_qr},
                      Choice{"dense_svd", Solver::dense_svd}};
}

/// B of the conjugate gradients.
///
///   none, jacobi                 1, and the inverse diagonal
///   incomplete_cholesky          a factor without fill; refused where it breaks down
///   shifted_incomplete_cholesky  the same of a matrix with a raised diagonal where it breaks down; the report says so
enum class Precondition { none, jacobi, incomplete_cholesky, shifted_incomplete_cholesky };
constexpr auto choices(Precondition)
{
    return std::array{Choice{"none", Precondition::none}, Choice{"jacobi", Precondition::jacobi},
                      Choice{"incomplete_cholesky", Precondition::incomplete_cholesky},
                      Choice{"shifted_incomplete_cholesky", Precondition::shifted_incomplete_cholesky}};
}

/// What multigrid does.
///
///   v          V-cycles, from 0
///   full       the same, from nested iteration, which knows the values of held nodes where they are given
///   cascading  no cycle: nested iteration by conjugate gradients, and then these with the diagonal on the finest level
enum class Cycle { v, full, cascading };
constexpr auto choices(Cycle)
{
    return std::array{Choice{"v", Cycle::v}, Choice{"full", Cycle::full},
                      Choice{"cascading", Cycle::cascading}};
}

struct SolverOptions
{
    Solver solver = Solver::automatic;
    Ordering ordering = Ordering::automatic; ///< of the sparse Cholesky factors
    Precondition preconditioner = Precondition::jacobi;
    Cycle cycle = Cycle::full;
    double tolerance =
        1e-8; ///< of iterations: |b - A x| / |b|, and of the cycles v and full |B r| / |x|, largest entries
    int max_iterations = 10000;
    bool error_bound = false; ///< whether to find one, at the cost of 16 solutions of one column
};

/// What a solution cost, and how good it is.
struct SolutionReport
{
    Solver solver = Solver::automatic; ///< that was chosen
    std::string why;                   ///< it was chosen, and what had to be changed: a sentence
    double setup = 0;      ///< seconds: checks, and the order of elimination
    double precompute = 0; ///< seconds: the factor, the preconditioner or the hierarchy
    double solve = 0;      ///< seconds
    int iterations = 0;    ///< 0 of direct solvers
    double residual = 0;   ///< |b - A x| / |b| of the worst column
    double error_bound =
        -1; ///< norm(A^-1) |b - A x| of the worst column, which bounds |x - A^-1 b|; -1 if not asked for
    std::int64_t bytes = 0;     ///< what was precomputed takes
    double fill = 0; ///< entries of the factor for each of the lower triangle of A; 0 without a factor
    std::int64_t envelope =
        0; ///< entries from the first of each row to the diagonal, in the order of elimination
    int levels = 0; ///< of the hierarchy; 0 without one
};

/// X = A^-1 B.
/// \param B  (m, k) any number of columns.
/// \throw InvalidOption  sizes do not match, a number is not finite, an option is out of its range, the matrix is not
///   symmetric and the solver needs that, or the solver cannot be used here. The message says what to choose instead.
/// \throw FactorizationFailed  A is singular, or not positive definite.
/// \throw NotConverged  the iterations are used up, or diverge.
/// \throw OutOfMemory, Cancelled
RowMatrix solve_linear(const LinearSystem& system, const RowMatrix& B, const SolverOptions& options,
                       SolutionReport& report, const Progress& progress = {});

} // namespace sinew
