// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/solvers/dissection/graph.h"

#include <vector>

namespace sinew {

/// Which side of a separator each node is on.
enum class Side : char { first, second, separator };

/// The fewest nodes without which no path leads from a node of `first` to one of `second`, by Menger's theorem as many
/// as there are such paths without a common node. Of several such separators it is the one nearest to `first`. The
/// paths are found by E. A. Dinic. "Algorithm for solution of a problem of maximum flow in a network with power
/// estimation." Soviet Math. Doklady 11, 1970, with nodes of capacity 1. Ends may be in the separator, too.
///
/// Cost: in the order of (edges) (number of phases), a dozen in meshes.
/// \param first, second  (n) flags. A node with both is always in the separator.
std::vector<Side> vertex_separator(const Graph& graph, const std::vector<char>& first,
                                   const std::vector<char>& second);

} // namespace sinew
