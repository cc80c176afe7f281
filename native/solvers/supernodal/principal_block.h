// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <cstdint>
#include <vector>

namespace sinew {

/// A view of the rows and columns `unknowns` of a symmetric matrix, so that a factorisation needs no copy of
/// them. Those of them that are not `free` are rows and columns of the identity.
class PrincipalBlock
{
public:
    /// Keeps references to all three.
    /// \param matrix    (n, n) with both triangles stored.
    /// \param unknowns  rows of the matrix, ascending.
    /// \param free      (n) whether each row of the matrix is unknown.
    PrincipalBlock(const SparseMatrix& matrix, const std::vector<int>& unknowns,
                   const std::vector<bool>& free);

    int size() const { return static_cast<int>(unknowns_.size()); }

    /// Calls visit(unknown, value) for each entry of a column that may differ from zero.
    template <class Visit>
    void column(int unknown, Visit&& visit) const
    {
        const int c = unknowns_[unknown];
        if (!free_[c]) {
            visit(unknown, 1.0);
            return;
        }
        for (SparseMatrix::InnerIterator it(matrix_, c); it; ++it)
            if (place_[it.row()] >= 0 && free_[it.row()])
                visit(place_[it.row()], it.value());
    }

    /// The block as a matrix. Rows of the identity keep the pattern of the matrix, with zeros.
    SparseMatrix copy() const;
    /// A digest of the pattern of copy().
    std::uint64_t digest() const;
    VectorX diagonal() const;

private:
    const SparseMatrix& matrix_;
    const std::vector<int>& unknowns_;
    const std::vector<bool>& free_;
    std::vector<int> place_; ///< (n) the index of each row in `unknowns`, or -1
};

/// A digest of the pattern.
std::uint64_t digest(const SparseMatrix& matrix);

} // namespace sinew
