// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/solvers/multigrid/hierarchy.h"
#include "native/solvers/spd_factor.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace sinew {

/// What a node has in each of four columns that are solved side by side.
using Four = Eigen::Array4f;
using Wide = Eigen::Array4d;

/// The values of held nodes, where they are not 0.
struct HeldValues
{
    std::vector<Wide> value;  ///< (nodes - free) of the finest level
    std::vector<Wide>
        beyond; ///< (nodes - free) what L of these nodes has from held nodes that are no part of the level
};

/// Approximate inverses of the operator of a hierarchy. All are linear and symmetric, but for the first guesses
/// full_cycle() and descend().
///
/// What a smoother adds is rough, and stands in single precision. What comes from the next level is smooth: on fine
/// meshes its second differences are below the rounding of single precision, so it and its residual are in double.
///
/// Smoother: J. Lottes. "Optimal polynomial smoothers for multigrid V-cycles." Numer. Linear Algebra Appl. 30(6), 2023,
/// of degree 4 in the diagonal times A. For the second order, restriction and prolongation are smoothed by two Jacobi
/// steps of L: with functions that are linear on each triangle alone, the energy of bends is far too large.
///
/// One object serves one thread.
class Cycles
{
public:
    static constexpr int never = 1000;
    /// \param hierarchy   must stay where it is.
    /// \param twice_from  the number of the finest level that a cycle visits twice, and so the next one four times:
    ///   never makes V-cycles, 1 W-cycles.
    /// \throw FactorizationFailed  the operator on the coarsest level is singular.
    explicit Cycles(const Hierarchy& hierarchy, int twice_from = never);

    /// (nodes) b of the next cycle, on the free nodes of the finest level.
    std::vector<Four>& right_side() { return work_.front().b; }

    /// x = one cycle for A x = b. Cost: nine products with A for each visit of a level. Smoothers whose bounds of
    /// eigenvalues are too small make a cycle that is not positive definite: then they are raised, and it begins again.
    /// \return (nodes) of the finest level, which the next call changes; null where no bounds help.
    const std::vector<Wide>* cycle();
    int raises() const { return raises_; } ///< of the bounds, so far

    /// Nested iteration, also called a full cycle: from the solution on the coarsest level through one cycle on each
    /// but the finest one. With the values of held nodes, no level begins with a jump beside them.
    /// \param held  empty where all are 0.
    std::vector<Wide> full_cycle(const HeldValues& held);

    /// From the coarsest level to the finest, without a way back: conjugate gradients with the diagonal on each level,
    /// more steps on coarser ones. F. A. Bornemann, P. Deuflhard. "The cascadic multigrid method for elliptic
    /// problems." Numer. Math. 75, 1996.
    const std::vector<Wide>& descend();

    /// y = A x on the free nodes of the finest level.
    /// \param x       (nodes) also of the held ones.
    /// \param beyond  as in HeldValues; empty for 0.
    void multiply(const std::vector<Wide>& x, const std::vector<Wide>& beyond, std::vector<Wide>& y);

    /// Ticks within cycles and products, until another one is given; null for none. It must live until then.
    void watch(const Progress* progress) { progress_ = progress; }

    std::int64_t bytes() const; ///< without the hierarchy

private:
    struct Work
    {
        std::vector<Four> b, r, step, middle, sum; ///< (nodes); zero on held nodes, but for middle
        std::vector<Wide> x, other; ///< (nodes); x is zero on held nodes
        std::vector<Wide> first; ///< (nodes) x of the first of two visits, only there
        float largest = 0; ///< a bound of the eigenvalues of A with the diagonal 1
    };

    template <class Column, class Body>
    void multiply_by_laplacian(int level, int count, const std::vector<Column>& x, Body&& body);
    template <class Column, class Body>
    void multiply(int level, const std::vector<Column>& x, std::vector<Column>& middle, Body&& body);
    float largest_eigenvalue(int level);
    void smooth(int level);
    void restrict_residual(int level);
    void prolong(int level, const std::vector<Wide>& coarse, std::vector<Wide>& x, std::vector<Wide>& other);
    void solve_coarsest();
    /// The coarsest level is solved at once.
    bool is_twice(int level) const
    {
        return level >= twice_from_ && level + 1 < static_cast<int>(work_.size());
    }
    void cycle(int level);
    void visit(int level);
    void restrict_all();
    template <class Body>
    void multiply_all(int level, const std::vector<Wide>& x, const std::vector<Wide>& beyond, Body&& body);
    void raise_bounds();
    void steps_of_conjugate_gradients(int level, int count);

    const Hierarchy& hierarchy_;
    int twice_from_;
    std::vector<Work> work_;
    SpdFactor coarsest_;
    RowMatrix columns_;
    int raises_ = 0;
    const Progress* progress_ = nullptr;
};

} // namespace sinew
