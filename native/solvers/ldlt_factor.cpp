// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/ldlt_factor.h"

#include <Eigen/SparseCholesky>

#include <algorithm>

namespace sinew {

namespace {

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
        const Eigen::Index entries = ldlt_.matrixL().nestedExpression().outerIndexPtr()[permuted_.cols()];
        return entries * (sizeof(double) + sizeof(int)) + permuted_.cols() * (sizeof(double) + sizeof(int));
    }

    std::int64_t nonzeros() const override
    {
        return ldlt_.matrixL().nestedExpression().nonZeros() + permuted_.cols();
    }

private:
    void permute(const SparseMatrix& matrix)
    {
        permuted_ = matrix.selfadjointView<Eigen::Lower>().twistedBy(permutation_);
    }

    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation_;
    SparseMatrix permuted_;
    Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>> ldlt_;
};

} // namespace

std::unique_ptr<FactorEngine> make_ldlt_factor() { return std::make_unique<LdltFactor>(); }

} // namespace sinew
