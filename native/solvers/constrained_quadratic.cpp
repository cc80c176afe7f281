// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/constrained_quadratic.h"

#include "native/core/errors.h"

#include <string>

namespace sinew {

void ConstrainedQuadratic::factorize(const SparseMatrix& matrix, const std::vector<bool>& free)
{
    const int n = static_cast<int>(matrix.cols());
    std::vector<int> place(n, -1);
    free_rows_.clear();
    for (int i = 0; i < n; ++i)
        if (free[i]) {
            place[i] = static_cast<int>(free_rows_.size());
            free_rows_.push_back(i);
        }
    const int unknowns = static_cast<int>(free_rows_.size());

    using Triplets = std::vector<Eigen::Triplet<double>>;
    Triplets inner, outer;
    inner.reserve(matrix.nonZeros());
    for (int c = 0; c < n; ++c)
        for (SparseMatrix::InnerIterator it(matrix, c); it; ++it) {
            const int r = place[it.row()];
            if (r < 0)
                continue;
            if (place[c] >= 0)
                inner.emplace_back(r, place[c], it.value());
            else
                outer.emplace_back(r, c, it.value());
        }
    SparseMatrix block(unknowns, unknowns);
    block.setFromTriplets(inner.begin(), inner.end());
    coupling_.resize(unknowns, n);
    coupling_.setFromTriplets(outer.begin(), outer.end());

    try {
        factor_.factorize(block);
    } catch (const FactorizationFailed& error) {
        if (error.elements().empty())
            throw;
        const int row = free_rows_[error.elements().front()];
        throw FactorizationFailed("the system is singular; it broke down at vertex " + std::to_string(row),
                                  Error::Element::vertex, {row});
    }
}

MatrixX ConstrainedQuadratic::solve(MatrixX& x, const MatrixX* rhs) const
{
    MatrixX b = -(coupling_ * x);
    if (rhs)
        for (std::size_t f = 0; f < free_rows_.size(); ++f)
            b.row(f) += rhs->row(free_rows_[f]);
    const MatrixX solution = factor_.solve(b);
    for (std::size_t f = 0; f < free_rows_.size(); ++f)
        x.row(free_rows_[f]) = solution.row(f);
    return b;
}

} // namespace sinew
