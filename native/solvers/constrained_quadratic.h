// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/solvers/spd_factor.h"

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
    explicit ConstrainedQuadratic(const FactorOptions& options = {}) : factor_(options) {}

    /// \param matrix  (n, n) symmetric positive semi-definite, both triangles stored.
    /// \param free    (n) true where x is unknown. A_ff must be positive definite.
    /// \throw FactorizationFailed  A_ff is singular; the element named is a row of `matrix`.
    void factorize(const SparseMatrix& matrix, const std::vector<bool>& free);

    /// \param[in,out] x  (n, k) the given rows in, all rows out.
    /// \param rhs        (n, k) b; null for zero.
    /// \return           (unknowns, k) the right-hand side b_f - A_fc x_c that was solved for.
    MatrixX solve(MatrixX& x, const MatrixX* rhs = nullptr) const;

    const std::vector<int>& free_rows() const { return free_rows_; }
    const SpdFactor& factor() const { return factor_; }

private:
    std::vector<int> free_rows_;
    SparseMatrix coupling_; ///< A_fc over all n columns, those of free unknowns empty
    SpdFactor factor_;
};

} // namespace sinew
