// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/solvers/constrained_quadratic.h"
#include "native/solvers/linear_system.h"

namespace sinew {

/// While one of these lives, ConstrainedQuadratic keeps in it the last system that it has solved on this thread, and a
/// method whose matrix is no plain Laplacian says what it is made of.
class SolvedSystem
{
public:
    SolvedSystem() : outer_(current) { current = this; }
    ~SolvedSystem() { current = outer_; }
    SolvedSystem(const SolvedSystem&) = delete;
    SolvedSystem& operator=(const SolvedSystem&) = delete;

    /// The innermost one of this thread, or null.
    static SolvedSystem* of_thread() { return current; }

    /// \param x           (n, k) with the values of the rows that are given
    /// \param right_side  (unknowns, k)
    void keep(const ConstrainedQuadratic::Problem& problem, const RowMatrix& x, const RowMatrix& right_side);
    /// Says what the last system is made of, as in LinearSystem.
    void describe(const SparseMatrix& graph, VectorX mass, int order, double membrane = 0);

    bool is_empty() const { return !problem_.matrix; }
    /// The system of the free unknowns. Without a description, its graph is the matrix of all, with the order 1.
    LinearSystem system() const;

private:
    static thread_local SolvedSystem* current;

    SolvedSystem* outer_;
    ConstrainedQuadratic::Problem problem_;
    LinearSystem described_;
    RowMatrix held_, right_side_;
};

} // namespace sinew
