// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/solvers/constrained_quadratic.h"
#include "native/solvers/linear_system.h"

#include <cstdint>
#include <memory>

namespace sinew {

/// What ConstrainedQuadratic solves, by iterations on a hierarchy of coarser graphs: for systems whose factor needs too
/// much memory. Neither a factor nor the matrix is ever there; A follows from the graph and the masses.
///
///   call          repeat it when ...               cost
///   constructor   the matrix or its rows changed   O(n), the time of some five iterations
///   solve()       the given rows changed           8 to 25 iterations on clean meshes, 60 and more on rough ones
class MultigridSolver
{
public:
    /// What solver and solution take together, from the size of the system alone.
    static std::int64_t bytes_for(const LinearSystem& system);

    /// \param system  of order 1 or 2, with nodes and pulls, and without a matrix; it is not kept.
    /// \throw OutOfMemory  bytes_for() is more than limit_memory() allows.
    /// \throw FactorizationFailed  the system is singular on its coarsest level.
    /// \throw Cancelled
    MultigridSolver(const LinearSystem& system, const Progress& progress);
    ~MultigridSolver();

    struct Solution
    {
        int iterations = 0;
        ConstrainedQuadratic::Norms norms;
    };

    /// Until the estimated error is below 5e-5 of the largest x against the mean of the given rows.
    /// \param[in,out] x  (n, k) with the given rows at first, with all rows afterwards.
    /// \param rhs        (n, k) b; null for zero. Given rows of b are not read.
    /// \param start      (n, k) what the iteration starts from; null for a coarse solution. The solution depends on it
    ///   within the tolerance.
    /// \throw NotConverged  the iterations stall.
    /// \throw Cancelled
    Solution solve(RowMatrix& x, const RowMatrix* rhs, const RowMatrix* start,
                   const Progress& progress) const;

    Eigen::Index rows() const; ///< n
    std::int64_t bytes() const; ///< of the solver and one workspace

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace sinew
