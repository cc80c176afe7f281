// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/solvers/orderings.h"
#include "native/solvers/spd_factor.h"
#include "native/solvers/supernodal/solve.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace sinew {

/// The order in which factorize() eliminates the unknowns of a (n, n) symmetric matrix, by its pattern alone:
/// nested dissection where it is to be had, else minimum degree.
std::vector<int> fill_reducing_order(const SparseMatrix& matrix);

/// A factor kept in single precision, for solves that need no more: preconditioners, Newton steps.
///
/// Half the memory of SpdFactor, and where that fits into a cache and the double one does not, two to three
/// times its speed. A solution has a relative error of 1e-7 (Laplacians of 10^4 unknowns) to 5e-7 (10^6);
/// solving for what is left squares it. Factorised in double precision.
///
///   call          cost
///   factorize()   SpdFactor::factorize, and a copy
///   solve()       two passes over the factor
class SingleFactor
{
public:
    /// \param matrix  (n, n) symmetric, both triangles or the lower one stored.
    /// \throw as SpdFactor::factorize
    void factorize(const SparseMatrix& matrix) { factorize(matrix, fill_reducing_order(matrix)); }
    /// The same with unknown order[i] eliminated as number i, or nearby.
    void factorize(const SparseMatrix& matrix, const std::vector<int>& order);

    /// X = A^-1 B. Safe from several threads at once; B may be X.
    /// \param rhs  (n, k) with k <= 4.
    void solve(const Points& rhs, Points& solution) const;
    void solve(const MatrixX& rhs, MatrixX& solution) const;

    int size() const { return size_; }
    /// The unknown eliminated at each position; neighbours in it are neighbours in the mesh.
    const std::vector<int>& order() const { return order_; }
    /// Unknown i is called names[i] from now on.
    void rename(const std::vector<int>& names);
    std::int64_t bytes() const;

private:
    template <class Rows>
    void solve_rows(const Rows& rhs, Rows& solution) const;

    int size_ = 0;
    std::vector<int> order_, first_, row_begin_, block_begin_, rows_;
    std::vector<float> values_;
    std::unique_ptr<SupernodalSolve<float>> supernodal_;
    std::unique_ptr<SpdFactor> other_; ///< where no supernodal factor is to be had
};

} // namespace sinew
