// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/solvers/dissection/graph.h"

#include <vector>

namespace sinew {

/// A graph cut into connected patches of some thirty nodes, and the graph of the patches that touch.
struct Patches
{
    std::vector<int> of; ///< (n) the patch of each node
    Graph touching;
};

/// Seeds are taken in the order of the nodes, each with the fewest rings around it that hold enough nodes, in which no
/// other seed is taken later. A node belongs to the nearest seed, of several to the first.
Patches patches_of(const Graph& graph);

} // namespace sinew
