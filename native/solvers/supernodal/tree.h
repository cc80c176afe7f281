// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace sinew {

/// A supernodal Cholesky factor P A P^T = L L^T that somebody else owns and keeps.
///
/// Supernode s has columns [first[s], first[s + 1]) and the rows rows[row_begin[s], row_begin[s + 1]), its
/// own columns first, ascending; its values stand column-major at values + block_begin[s], one row a line.
/// `padding` finite numbers stand behind the last value: whoever reads several rows at once reads past it.
template <class T>
struct BasicSupernodalFactor
{
    static constexpr int padding = 8;

    int size = 0;
    int supernodes = 0;
    const int* permutation = nullptr; ///< (size) unknown of each position
    const int* first = nullptr;
    const int* row_begin = nullptr;
    const int* block_begin = nullptr;
    const int* rows = nullptr;
    T* values = nullptr; ///< the strict upper triangles of the diagonal blocks are ours to use

    int columns(int s) const { return first[s + 1] - first[s]; }
    int height(int s) const { return row_begin[s + 1] - row_begin[s]; }
    const int* rows_of(int s) const { return rows + row_begin[s]; }
    T* block(int s) const { return values + block_begin[s]; }
};

using SupernodalFactor = BasicSupernodalFactor<double>;

/// The elimination tree of the supernodes. They are numbered in postorder.
struct SupernodalTree
{
    std::vector<int> owner;  ///< (size) supernode of each column
    std::vector<int> parent; ///< (supernodes) -1 for a root

    template <class T>
    explicit SupernodalTree(const BasicSupernodalFactor<T>& factor);
};

/// The tree cut into subtrees that do not need each other, and what is left above them.
struct SupernodalSplit
{
    /// Supernodes [begin, end) with everything below them: some neighbouring subtrees.
    struct Part
    {
        int begin, end;
    };
    std::vector<Part> parts;
    std::vector<char> on_top; ///< (supernodes)
};

/// Cuts at the heaviest until no part is above 1/count of the total weight.
SupernodalSplit split(const SupernodalTree& tree, std::vector<double> weights, int count);

} // namespace sinew
