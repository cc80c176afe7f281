// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/solvers/supernodal/tree.h"

#include <functional>
#include <memory>
#include <vector>

namespace sinew {

/// Triangular solves with a supernodal factor of doubles or floats for up to four right-hand sides at once.
///
/// A solve reads the factor twice; each value read serves all columns. Subtrees of the elimination tree
/// run in parallel, and what they add to the unknowns above them is summed in a fixed order: the result
/// does not depend on the number of threads. Blocks of the diagonal are inverted beforehand, in place of
/// their unused upper triangles, so that no chain of divisions stalls the solve.
///
///   call         cost
///   constructor  O(n b^2) for blocks of b = 16 columns
///   solve()      two passes over the factor
template <class T>
class SupernodalSolve
{
public:
    explicit SupernodalSolve(const BasicSupernodalFactor<T>& factor);
    ~SupernodalSolve();

    /// After other values were computed in the `chosen` supernodes; no solve may run meanwhile.
    void renew(const std::vector<char>& chosen);

    /// X = A^-1 B; (n, k) with k <= 4. Safe from several threads; keeps its workspace.
    void solve(const MatrixX& rhs, MatrixX& solution) const;
    /// The same in place for columns [first, first + k) of x, k <= 4.
    void solve_rows(RowMatrix& x, int first, int k) const;
    /// The same on (n) points of four lanes in elimination order, of which the first k are solved, at least
    /// three: `fill` writes B, `read` gets X.
    void sweep(int k, const std::function<void(T* points)>& fill,
               const std::function<void(const T* points)>& read) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace sinew
