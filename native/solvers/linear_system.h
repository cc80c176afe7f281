// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <vector>

namespace sinew {

/// The equations A x = b of a method, and what is known of where they come from. Nodes are the vertices of a mesh or of
/// any graph in space; an unknown belongs to each free node, and held nodes have the value 0.
struct LinearSystem
{
    SparseMatrix matrix; ///< (m, m) A, symmetric with both triangles stored where nothing else is said
    RowMatrix right_side; ///< (m, k) b; may be empty
    std::vector<int> vertices; ///< (m) the node of each unknown, ascending
    RowMatrix
        held; ///< (n, k) the values of held nodes that b comes from, 0 at the others; empty where not known

    // What multigrid needs; empty where it is not known.
    Points points; ///< (n, 3) the nodes
    SparseMatrix graph; ///< (n, n) L, symmetric; its rows have the sum 0, but for what pulls at a node
    VectorX mass; ///< (n) M, positive; infinite where a node does not count
    int order =
        1; ///< A is the block of the unknowns in L, or with 2 in L M^-1 L + membrane L; 3 and more: others
    double membrane = 0;
    VectorX
        pulls; ///< (m) what A has on its diagonal beside these, where there is no matrix to read that from

    bool has_nodes() const { return points.rows() > 0 && graph.rows() == points.rows(); }
};

/// \throw InvalidOption  sizes do not match, or a number is out of its range or not finite.
void require_consistent(const LinearSystem& system);

} // namespace sinew
