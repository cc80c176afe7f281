// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/solvers/supernodal/principal_block.h"
#include "native/solvers/supernodal/tree.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace sinew {

/// What a sparse Cholesky library has to offer to stand behind SpdFactor.
class FactorEngine
{
public:
    virtual ~FactorEngine() = default;

    /// Symbolic factorisation of the lower triangle, in the given elimination order.
    virtual void analyze(const SparseMatrix& matrix, const std::vector<int>& order) = 0;

    /// Numeric factorisation of a matrix with the analysed pattern. Returns the unknown at
    /// which it broke down, or -1.
    virtual int factorize(const SparseMatrix& matrix) = 0;
    virtual int factorize(const PrincipalBlock& block) { return factorize(block.copy()); }

    /// Numeric factorisation after a change of the `changed` rows and columns of the block alone. It computes
    /// only what depends on them, and its result is that of factorize() to the last bit. It does nothing and
    /// returns an empty value if the engine cannot do this, or if more than the share `most` of the work of
    /// factorize() would have to be done. Otherwise it sets `share` to the share of that work that was done.
    virtual std::optional<int> update(const PrincipalBlock& /*block*/, const std::vector<int>& /*changed*/,
                                      double /*most*/, double& /*share*/)
    {
        return {};
    }

    /// X = A^-1 B, column by column. Safe from several threads at once.
    virtual void solve(const MatrixX& rhs, MatrixX& solution) const = 0;

    /// The same by rows, in place.
    virtual void solve_rows(RowMatrix& x) const
    {
        MatrixX solution(x.rows(), x.cols());
        solve(x, solution);
        x = solution;
    }

    /// The factor itself where it is supernodal, with values; else none.
    virtual std::optional<SupernodalFactor> supernodal() const { return {}; }

    /// What was left of each unknown's diagonal entry when it was eliminated.
    virtual VectorX pivots() const = 0;

    /// Memory of the factor, in bytes; known from analyze() on.
    virtual std::int64_t bytes() const = 0;

    /// Entries of the factor.
    virtual std::int64_t nonzeros() const = 0;
};

} // namespace sinew
