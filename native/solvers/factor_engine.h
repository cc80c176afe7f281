// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/solvers/supernodal_solve.h"

#include <cstdint>
#include <memory>
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

    /// X = A^-1 B, column by column. Safe from several threads at once.
    virtual void solve(const MatrixX& rhs, MatrixX& solution) const = 0;

    /// The factor itself, where it is supernodal; else null.
    virtual const SupernodalFactor<double>* supernodal() const { return nullptr; }

    /// What was left of each unknown's diagonal entry when it was eliminated.
    virtual VectorX pivots() const = 0;

    /// Memory of the factor, in bytes; known from analyze() on.
    virtual std::int64_t bytes() const = 0;

    /// Entries of the factor.
    virtual std::int64_t nonzeros() const = 0;
};

} // namespace sinew
