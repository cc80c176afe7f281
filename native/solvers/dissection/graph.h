// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <span>
#include <vector>

namespace sinew {

/// The pattern of a symmetric matrix: an edge for each entry beside the diagonal.
struct Graph
{
    std::vector<int> offsets{0}; ///< (n + 1)
    std::vector<int> neighbours; ///< of each node

    int size() const { return static_cast<int>(offsets.size()) - 1; }
    std::span<const int> of(int node) const
    {
        return {neighbours.data() + offsets[node], neighbours.data() + offsets[node + 1]};
    }
};

/// \param matrix  (n, n) symmetric, both triangles or the lower one stored.
/// \return neighbours in ascending order.
Graph graph_of(const SparseMatrix& matrix);

} // namespace sinew
