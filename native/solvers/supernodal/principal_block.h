// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <cstdint>
#include <vector>

namespace sinew {

/// The rows and columns `unknowns` of a symmetric matrix, read where they stand: a factorisation needs no
/// copy of them. Those that are not `free` stand as rows and columns of the identity.
class PrincipalBlock
{
public:
    /// \param matrix    (n, n) both triangles stored.
    /// \param unknowns  ascending. All three are kept by reference.
    /// \param free      (n)
    PrincipalBlock(const SparseMatrix& matrix, const std::vector<int>& unknowns,
                   const std::vector<bool>& free);

    int size() const { return static_cast<int>(unknowns_.size()); }

    /// visit(unknown, value) for the entries of a column that may differ from zero.
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

    /// The block for itself. Rows of the identity keep their pattern, with zeros.
    SparseMatrix copy() const;
    /// Of the pattern of copy().
    std::uint64_t digest() const;
    VectorX diagonal() const;

private:
    const SparseMatrix& matrix_;
    const std::vector<int>& unknowns_;
    const std::vector<bool>& free_;
    std::vector<int> place_; ///< (n) unknown of a row, or -1
};

/// Of the pattern alone.
std::uint64_t digest(const SparseMatrix& matrix);

} // namespace sinew
