// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace sinew {

/// The surroundings of a vertex in a mesh of quads (Catmull-Clark) or triangles (Loop). Edge k leads to
/// neighbour k and lies between faces k - 1 and k. At an open border there is one face less than edges.
struct Neighbourhood
{
    bool triangles = false;
    int faces = 0;
    double sharpness = 0.0;             ///< of the vertex
    std::vector<double> edge_sharpness; ///< of each edge; from 10 on, the edge is sharp on all levels
};

/// The weights of a vertex's limit position: those of the vertex, then those of its neighbours along edges,
/// and in quads those of the corners opposite to it in its faces.
///
/// One step of subdivision takes these points to those of the next level by a small matrix, which depends on
/// the sharpness left at that level (T. DeRose et al. 1998; a fractional sharpness blends the two rules). The
/// limit is the product of these matrices, the last one raised to a high power. It is exact also where the
/// known limit masks are not: at the end of an edge that is sharp on all levels, and where sharpness is left.
std::vector<double> limit_mask(const Neighbourhood& around);

} // namespace sinew
