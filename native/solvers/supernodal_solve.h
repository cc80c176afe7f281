// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <memory>

namespace sinew {

/// A supernodal Cholesky factor P A P^T = L L^T that somebody else owns and keeps.
///
/// Supernode s has columns [first[s], first[s + 1]) and the rows rows[row_begin[s], row_begin[s + 1]), its
/// own columns first, ascending; its values stand column-major at values + block_begin[s], one row a line.
template <class T>
struct SupernodalFactor
{
    int size = 0;
    int supernodes = 0;
    const int* permutation = nullptr; ///< (size) unknown of each position
    const int* first = nullptr;
    const int* row_begin = nullptr;
    const int* block_begin = nullptr;
    const int* rows = nullptr;
    T* values = nullptr; ///< the strict upper triangles of the diagonal blocks are ours to use
};

/// Triangular solves with a supernodal factor, of doubles or floats, for up to four right-hand sides at once.
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
    explicit SupernodalSolve(const SupernodalFactor<T>& factor);
    ~SupernodalSolve();

    /// X = A^-1 B; (n, k) with k <= 4. Safe from several threads; keeps its workspace.
    void solve(const MatrixX& rhs, MatrixX& solution) const;

    /// The same in place, on (n) points of four lanes in elimination order.
    void sweep(T* points) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace sinew
