// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/trees/triangle_tree.h"

#include <vector>

namespace sinew {

using Polygons = std::vector<std::vector<int>>;

Polygons polygons(const std::vector<Triangle>& triangles);

/// Joins triangles of a surface that does not cross itself into quads, the pairs closest to rectangles first.
/// Two triangles are joined only if the surface cut along the other diagonal does not cross itself or
/// `within` either, and fifteen points of each new triangle are at least `apart` away from `within`: so the
/// surface encloses `within` whichever diagonal a program cuts the quad along. No diagonal of a quad is an
/// edge of the surface or a diagonal of another quad, so that never more than two triangles meet at an edge.
/// Quads and remaining triangles come in the order of their first triangles.
///
/// \param mirror_axis  0 to 2 for one half of a mirrored surface, whose vertices on the mirror have the
///                     coordinate 0 along it; -1 for a whole surface.
Polygons paired(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles,
                const TriangleTree& within, double apart, int mirror_axis);

} // namespace sinew
