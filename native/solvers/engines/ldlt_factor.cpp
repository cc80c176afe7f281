// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/engines/ldlt_factor.h"

#include <Eigen/SparseCholesky>

#include <algorithm>

namespace sinew {

namespace {

/// Gives the number of entries after the symbolic step; Eigen's own class has it only after the numeric one.
class Ldlt : public Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>>
{
public:
    /// Entries below the diagonal.
    std::int64_t entries() const
    {
        return m_matrix.cols() > 0 ? m_matrix.outerIndexPtr()[m_matrix.cols()] : 0;
    }
};

class LdltFactor final : public FactorEngine
{
public:
    void analyze(const SparseMatrix& matrix, const std::vector<int>& order) override
    {
        // Eigen applies P A P^T with P.indices()[old] = new.
        permutation_.resize(static_cast<int>(order.size()));
        for (int i = 0; i < static_cast<int>(order.size()); ++i)
            permutation_.indices()[order[i]] = i;
        permute(matrix);
        ldlt_.analyzePattern(permuted_);
    }

    using FactorEngine::factorize;
    int factorize(const SparseMatrix& matrix) override
    {
        permute(matrix);
        ldlt_.factorize(permuted_);
        if (ldlt_.info() == Eigen::Success)
            return -1;
        // Eigen stops at the first pivot that is exactly zero.
        const VectorX d = ldlt_.vectorD();
        const auto zero = std::find(d.begin(), d.end(), 0.0) - d.begin();
        return permutation_.inverse().eval().indices()[zero];
    }

    void solve(const MatrixX& rhs, MatrixX& solution) const override
    {
        solution = permutation_.inverse() * ldlt_.solve(permutation_ * rhs);
    }

    VectorX pivots() const override { return permutation_.inverse() * ldlt_.vectorD(); }

    std::int64_t bytes() const override
    {
        return (ldlt_.entries() + permuted_.cols()) * static_cast<std::int64_t>(sizeof(double) + sizeof(int));
    }

    std::int64_t nonzeros() const override { return ldlt_.entries() + permuted_.cols(); }

private:
    void permute(const SparseMatrix& matrix)
    {
        permuted_ = matrix.selfadjointView<Eigen::Lower>().twistedBy(permutation_);
    }

    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation_;
    SparseMatrix permuted_;
    Ldlt ldlt_;
};

} // namespace

std::unique_ptr<FactorEngine> make_ldlt_factor() { return std::make_unique<LdltFactor>(); }

} // namespace sinew
