// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/triangle_tree.h"

#include <vector>

namespace sinew {

using Polygons = std::vector<std::vector<int>>;

Polygons polygons(const std::vector<Triangle>& triangles);

/// Joins triangles of a surface that does not cross itself into quads, the pairs closest to rectangles first.
/// Two triangles are joined only if the surface cut along the other diagonal does not cross itself or
/// `within` either, and fifteen points of each new triangle are at least `apart` away from `within`: so the
/// surface encloses `within` whichever diagonal a program cuts the quad along. Quads and remaining triangles
/// come in the order of their first triangles.
Polygons paired(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles,
                const TriangleTree& within, double apart);

} // namespace sinew
