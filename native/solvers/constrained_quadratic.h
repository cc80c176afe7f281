// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/solvers/spd_factor.h"

#include <memory>
#include <vector>

namespace sinew {

/// Minimises 1/2 x^T A x - b^T x where some entries x_c of x are given:
///
///     A_ff x_f = b_f - A_fc x_c
///
/// It is factorised once and solved for any number of columns.
class ConstrainedQuadratic
{
public:
    /// What is factorised. `unknowns` are the rows that the factor was analysed for, ascending. Some of them
    /// may have become given rows since then; in the factor, these are rows of the identity.
    struct Problem
    {
        std::shared_ptr<const SparseMatrix> matrix; ///< null before factorize()
        std::vector<bool> free;                     ///< (n) whether each row is unknown
        std::vector<int> unknowns;
    };

    /// Inner products between the columns of a solution, see forms().
    struct Forms
    {
        MatrixX energy;   ///< x^T A x
        MatrixX residual; ///< of A x - b on the unknowns
        MatrixX load;     ///< of the right-hand side b_f - A_fc x_c
    };

    /// The traces of Forms: the same for all columns together.
    struct Norms
    {
        double energy = 0, residual = 0, load = 0;
    };

    /// The workspace of solve().
    struct Workspace
    {
        RowMatrix unknowns;
    };

    explicit ConstrainedQuadratic(const FactorOptions& options = {}) : factor_(options) {}

    /// If the pattern is the same and only some entries changed, or some free rows became given ones, only
    /// the part of the factor that depends on these is computed again.
    ///
    /// \param matrix  (n, n) symmetric positive semi-definite, both triangles stored; kept.
    /// \param free    (n) true where x is unknown. A_ff must be positive definite.
    /// \param wider   (n) rows for which a new factor is analysed, too, so that it can share the analysis of
    ///   one in which they are free; not where there are too many. Empty for none.
    /// \throw FactorizationFailed  A_ff is singular; the element of the error is a row of `matrix`. Call
    ///   restore() with the former problem() then.
    void factorize(std::shared_ptr<const SparseMatrix> matrix, const std::vector<bool>& free,
                   const std::vector<bool>& wider = {});

    /// The rows of the free vertices and, where they are not too many, of the wider ones.
    static std::vector<int> unknowns_of(const std::vector<bool>& free, const std::vector<bool>& wider);

    /// Factorises a former problem() again, with the same bits as before.
    void restore(Problem problem);

    /// \param[in,out] x  (n, k) with the given rows at first, with all rows afterwards.
    /// \param rhs        (n, k) b; null for zero.
    void solve(RowMatrix& x, const RowMatrix* rhs = nullptr) const;
    /// The same with a workspace that is kept from call to call, so that no large array is allocated.
    void solve(RowMatrix& x, const RowMatrix* rhs, Workspace& work) const;

    /// \param x, rhs  a solution of solve() and its right-hand side.
    Forms forms(const RowMatrix& x, const RowMatrix* rhs = nullptr) const;
    Norms norms(const RowMatrix& x, const RowMatrix* rhs = nullptr) const;

    /// (unknowns, k) the right-hand side b_f - A_fc x_c that solve() solves for; zero where a row is given.
    RowMatrix right_side(const RowMatrix& x, const RowMatrix* rhs = nullptr) const;

    const Problem& problem() const { return problem_; }
    const SpdFactor& factor() const { return factor_; }

private:
    bool update(const Problem& next);
    void factorize(Problem next);
    void adopt(Problem next);
    void right_side(const RowMatrix& x, const RowMatrix* rhs, RowMatrix& b) const;
    void right_side_row(int row, const RowMatrix& x, const RowMatrix* rhs, double* b) const;

    Problem problem_;
    std::vector<char> bordering_; ///< (n) whether each row is free and has a neighbour that is given
    SpdFactor factor_;
};

} // namespace sinew
