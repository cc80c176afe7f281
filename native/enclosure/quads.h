// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/triangle_tree.h"

#include <vector>

namespace sinew {

using Polygons = std::vector<std::vector<int>>;

Polygons polygons(const std::vector<Triangle>& triangles);

/// Joins triangles of an embedded surface into quads, the squarest and flattest pairs first. A pair is
/// joined where along the other diagonal, too, the surface would be embedded, free of `within`, and as far
/// as fifteen points of a triangle can tell by `apart` away from it: whichever diagonal somebody cuts the
/// quad along, it encloses. Quads and left triangles come in the order of their first triangle.
Polygons paired(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles,
                const TriangleTree& within, double apart);

} // namespace sinew
