// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/types.h"
#include "native/solvers/supernodal/tree.h"

#include <functional>
#include <vector>

namespace sinew {

/// Triangular solves with a supernodal factor of doubles or floats for up to four right-hand sides at once.
///
/// A solve reads the factor twice, and uses each value for all right-hand sides. Subtrees of the elimination
/// tree run in parallel. Their contributions to the unknowns above them are summed in a fixed order, so the
/// result does not depend on the number of threads. The constructor inverts blocks of the diagonal and stores
/// the inverses in the unused upper triangles, so that a solve does not wait for divisions.
///
///   call         cost
///   constructor  O(n b^2) for blocks of b = 16 columns
///   solve()      two passes over the factor
template <class T>
class SupernodalSolve
{
public:
    explicit SupernodalSolve(const BasicSupernodalFactor<T>& factor);

    /// Call this after the values of the `chosen` supernodes have changed, while no solve runs.
    void renew(const std::vector<char>& chosen);

    /// X = A^-1 B, for (n, k) right-hand sides with k <= 4. Several threads may call it at once. The
    /// workspace is kept for later calls.
    void solve(const MatrixX& rhs, MatrixX& solution) const;
    /// The same in place for columns [first, first + k) of x, k <= 4.
    void solve_rows(RowMatrix& x, int first, int k) const;
    /// The same for (n) points of four lanes in the order of elimination. The first k lanes are solved, or
    /// three if k is less.
    /// \param fill  writes B.
    /// \param read  gets X.
    void sweep(int k, const std::function<void(T* points)>& fill,
               const std::function<void(const T* points)>& read) const;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew
