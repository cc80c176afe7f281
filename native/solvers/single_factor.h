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

/// The order in which factorize() eliminates the unknowns of a (n, n) symmetric matrix. It depends on the
/// pattern alone: minimum degree below 10,000 unknowns, above that nested dissection in builds that have it.
std::vector<int> fill_reducing_order(const SparseMatrix& matrix);

/// A factor in single precision, for solves that need no more, such as preconditioners and Newton steps. The
/// factorisation itself runs in double precision.
///
/// It takes half the memory of SpdFactor; where that fits into a cache and a factor in double precision does
/// not, solves are two to three times faster. A solution has a relative error of 1e-7 (Laplacians of 10^4
/// unknowns) to 5e-7 (10^6); a second solve for the residual squares it.
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
    /// The same with unknown order[i] eliminated as number i, or as a number close to it.
    void factorize(const SparseMatrix& matrix, const std::vector<int>& order);

    /// Takes a factor over, whose values in double precision are freed.
    void adopt(std::unique_ptr<SpdFactor> factor);

    /// X = A^-1 B. Several threads may call it at once; B may be X.
    /// \param rhs  (n, k) with k <= 4.
    void solve(const Points& rhs, Points& solution) const;
    void solve(const MatrixX& rhs, MatrixX& solution) const;

    int size() const { return size_; }
    /// The unknown eliminated at each position. Unknowns that follow one another in it are close to each
    /// other in the mesh.
    const std::vector<int>& order() const { return order_; }
    /// From now on, unknown i has the number names[i].
    void rename(const std::vector<int>& names);
    std::int64_t bytes() const;

private:
    void adopt(std::unique_ptr<SpdFactor> factor, const std::vector<int>& order);
    template <class Rows>
    void solve_rows(const Rows& rhs, Rows& solution) const;

    int size_ = 0;
    std::vector<int> order_, first_, row_begin_, block_begin_, rows_;
    std::vector<float> values_;
    std::unique_ptr<SupernodalSolve<float>> supernodal_;
    std::unique_ptr<SpdFactor> other_; ///< used where the engine gives no supernodal factor
};

} // namespace sinew
