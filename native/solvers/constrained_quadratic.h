// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/solvers/spd_factor.h"

#include <memory>
#include <vector>

namespace sinew {

/// Minimiser of 1/2 x^T A x - b^T x with some entries of x given:
///
///     A_ff x_f = b_f - A_fc x_c
///
/// factorised once, solved for any number of columns.
class ConstrainedQuadratic
{
public:
    /// What is factorised. `unknowns` are the rows that the factor was analysed for, ascending; those that
    /// were given later stand in it as rows of the identity.
    struct Problem
    {
        std::shared_ptr<const SparseMatrix> matrix; ///< null before factorize()
        std::vector<bool> free;                     ///< (n)
        std::vector<int> unknowns;
    };

    /// Inner products of the columns of x over all rows, see forms().
    struct Forms
    {
        MatrixX energy;   ///< x^T A x
        MatrixX residual; ///< of A x - b on the unknowns
        MatrixX load;     ///< of the right-hand side b_f - A_fc x_c
    };

    /// Their traces: the same over all columns together.
    struct Norms
    {
        double energy = 0, residual = 0, load = 0;
    };

    /// What solve() needs a frame.
    struct Workspace
    {
        RowMatrix unknowns;
    };

    explicit ConstrainedQuadratic(const FactorOptions& options = {}) : factor_(options) {}

    /// Where some of the free rows became given ones and some entries others, under the same pattern, only
    /// what they reach in the factor is computed again, if that is little.
    ///
    /// \param matrix  (n, n) symmetric positive semi-definite, both triangles stored; kept.
    /// \param free    (n) true where x is unknown. A_ff must be positive definite.
    /// \throw FactorizationFailed  A_ff is singular; the element named is a row of `matrix`. restore() then
    ///   brings back the last problem().
    void factorize(std::shared_ptr<const SparseMatrix> matrix, const std::vector<bool>& free);

    /// Factorises what problem() was before, to the same bits.
    void restore(Problem problem);

    /// \param[in,out] x  (n, k) the given rows in, all rows out.
    /// \param rhs        (n, k) b; null for zero.
    void solve(RowMatrix& x, const RowMatrix* rhs = nullptr) const;
    /// The same with a workspace that stays from call to call: no array of the matrix' size is allocated.
    void solve(RowMatrix& x, const RowMatrix* rhs, Workspace& work) const;

    /// \param x, rhs  as solve() left them.
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
    std::vector<char> bordering_; ///< (n) free with a neighbour that is given
    SpdFactor factor_;
};

} // namespace sinew
