// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/solvers/multigrid/hierarchy.h"
#include "native/solvers/spd_factor.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace sinew {

/// What a node has in each of four columns that are solved side by side.
using Four = Eigen::Array4f;

/// Approximate inverses of the operator of a hierarchy, in single precision. All are linear and symmetric, but for
/// descend().
///
/// Smoother: J. Lottes. "Optimal polynomial smoothers for multigrid V-cycles." Numer. Linear Algebra Appl. 30(6), 2023,
/// of degree 4 in the diagonal times A. For the second order, restriction and prolongation are smoothed by two Jacobi
/// steps of L: with functions that are linear on each triangle alone, the energy of bends is far too large.
///
/// One object serves one thread.
class Cycles
{
public:
    /// \param hierarchy  must stay where it is.
    /// \throw FactorizationFailed  the operator on the coarsest level is singular.
    explicit Cycles(const Hierarchy& hierarchy);

    /// x = one V-cycle for A x = b. Cost: nine products with A on each level.
    /// \param b, x  (free) of the finest level.
    void v_cycle(const std::vector<Four>& b, std::vector<Four>& x);

    /// Nested iteration, also called a full cycle: from the solution on the coarsest level through one V-cycle on each.
    void full_cycle(const std::vector<Four>& b, std::vector<Four>& x);

    /// From the coarsest level to the finest, without a way back: conjugate gradients with the diagonal on each level,
    /// more steps on coarser ones. F. A. Bornemann, P. Deuflhard. "The cascadic multigrid method for elliptic
    /// problems." Numer. Math. 75, 1996.
    void descend(const std::vector<Four>& b, std::vector<Four>& x);

    /// Raises the bounds of eigenvalues from which the smoothers are made.
    void raise_bounds();

    std::int64_t bytes() const; ///< without the hierarchy

private:
    struct Work
    {
        std::vector<Four> b, x, r, step, next, middle; ///< (nodes); zero on held nodes
        float largest = 0; ///< a bound of the eigenvalues of A with the diagonal 1
    };

    template <class Body>
    void multiply(int level, const std::vector<Four>& x, Body&& body);
    template <class Body>
    void multiply_by_laplacian(int level, int count, const std::vector<Four>& x, Body&& body);
    float largest_eigenvalue(int level);
    void smooth(int level, bool from_zero);
    void find_residual(int level);
    void restrict_residual(int level);
    void prolong(int level, bool add);
    void solve_coarsest();
    void cycle(int level);
    void restrict_all(const std::vector<Four>& b);
    void steps_of_conjugate_gradients(int level, int count);
    void begin(const std::vector<Four>& b);
    void finish(std::vector<Four>& x) const;

    const Hierarchy& hierarchy_;
    std::vector<Work> work_;
    SpdFactor coarsest_;
    RowMatrix columns_;
};

} // namespace sinew
