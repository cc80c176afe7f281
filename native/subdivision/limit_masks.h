// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace sinew {

/// A vertex among quads (Catmull-Clark) or triangles (Loop) and its neighbours in order around it: edge k
/// leads to neighbour k and lies between faces k - 1 and k. One face less than edges: an open border.
struct Neighbourhood
{
    bool triangles = false;
    int faces = 0;
    double sharpness = 0.0;             ///< of the vertex
    std::vector<double> edge_sharpness; ///< 10 and more: for ever
};

/// The weights of the vertex's limit position: of itself, of its neighbours along edges, and among quads of
/// the corners opposite to it in its faces.
///
/// One step of subdivision takes these points to those of the next level by a small matrix, which the
/// sharpness left at that level decides on (T. DeRose et al. 1998, fractional sharpness blending the two
/// rules). The limit is the product of those matrices, the last one raised to a high power. So it is right
/// where closed masks are not: at the end of an endless crease, and where sharpness is left.
std::vector<double> limit_mask(const Neighbourhood& around);

} // namespace sinew
