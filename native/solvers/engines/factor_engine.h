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

/// What an engine knows of the pattern of a matrix.
struct Analysis
{
    Analysis() = default;
    virtual ~Analysis() = default;
    Analysis(const Analysis&) = delete;
    Analysis& operator=(const Analysis&) = delete;
};

/// The interface that SpdFactor needs of a sparse Cholesky library.
class FactorEngine
{
public:
    virtual ~FactorEngine() = default;

    /// Symbolic factorisation of the lower triangle, in the given elimination order.
    virtual void analyze(const SparseMatrix& matrix, const std::vector<int>& order) = 0;

    /// What analyze() found, for other engines of the same kind; null where they cannot share it.
    virtual std::shared_ptr<const Analysis> analysis() const { return nullptr; }
    /// Takes over what another engine of the same kind has found for the same pattern and order.
    virtual void adopt(const std::shared_ptr<const Analysis>& /*analysis*/) {}

    /// Numeric factorisation of a matrix with the analysed pattern.
    /// \return the unknown at which it broke down, or -1.
    virtual int factorize(const SparseMatrix& matrix) = 0;
    virtual int factorize(const PrincipalBlock& block) { return factorize(block.copy()); }

    /// The same for a block of which only the `changed` columns and rows differ from the last one. It
    /// computes only what depends on them, and the result is that of factorize() to the last bit.
    /// \param most        largest share of the work of factorize() to do.
    /// \param[out] share  the share that was done.
    /// \return as factorize(); nothing, and nothing is done, if the engine cannot do this, or the share would
    ///   be larger than `most`.
    virtual std::optional<int> update(const PrincipalBlock& /*block*/, const std::vector<int>& /*changed*/,
                                      double /*most*/, double& /*share*/)
    {
        return {};
    }

    /// X = A^-1 B. Several threads may call it at once.
    virtual void solve(const MatrixX& rhs, MatrixX& solution) const = 0;

    /// The same by rows and in place.
    virtual void solve_rows(RowMatrix& x) const
    {
        MatrixX solution(x.rows(), x.cols());
        solve(x, solution);
        x = solution;
    }

    /// The factor itself if it is supernodal and has values.
    virtual std::optional<SupernodalFactor> supernodal() const { return {}; }

    /// The pivot of each unknown: what was left of its diagonal entry when it was eliminated.
    virtual VectorX pivots() const = 0;

    /// Memory of the factor in bytes; known after analyze().
    virtual std::int64_t bytes() const = 0;

    /// Number of entries of the factor.
    virtual std::int64_t nonzeros() const = 0;
};

} // namespace sinew
