// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace sinew {

/// A view of a supernodal Cholesky factor P A P^T = L L^T.
///
/// Supernode s has the columns [first[s], first[s + 1]) and the rows rows[row_begin[s]] to rows[row_begin[s +
/// 1] - 1], ascending, of which the first are its own columns. Its values are at values + block_begin[s],
/// column-major. `padding` finite numbers follow the last value, as kernels that read several rows at once
/// read past it.
template <class T>
struct BasicSupernodalFactor
{
    static constexpr int padding = 8;

    int size = 0;
    int supernodes = 0;
    const int* permutation = nullptr; ///< (size) the unknown at each position
    const int* first = nullptr;
    const int* row_begin = nullptr;
    const int* block_begin = nullptr;
    const int* rows = nullptr;
    T* values = nullptr; ///< the strict upper triangles of the diagonal blocks may be overwritten

    int columns(int s) const { return first[s + 1] - first[s]; }
    int height(int s) const { return row_begin[s + 1] - row_begin[s]; }
    const int* rows_of(int s) const { return rows + row_begin[s]; }
    T* block(int s) const { return values + block_begin[s]; }
};

using SupernodalFactor = BasicSupernodalFactor<double>;

/// The elimination tree of the supernodes. They are numbered in postorder.
struct SupernodalTree
{
    std::vector<int> owner;  ///< (size) the supernode of each column
    std::vector<int> parent; ///< (supernodes) the parent of each supernode, -1 for a root

    template <class T>
    explicit SupernodalTree(const BasicSupernodalFactor<T>& factor);
};

/// The tree, cut into independent parts and the supernodes on top of them.
struct SupernodalSplit
{
    /// Supernodes [begin, end): some neighbouring subtrees.
    struct Part
    {
        int begin, end;
    };
    std::vector<Part> parts;
    std::vector<char> on_top; ///< (supernodes) whether each is on top
};

/// Cuts the heaviest subtree until none has more than 1/count of the total weight.
SupernodalSplit split(const SupernodalTree& tree, std::vector<double> weights, int count);

} // namespace sinew
