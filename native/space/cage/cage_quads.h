// SPDX-License-Identifier: GPL-3.0-or-later
// For every method of this room.
#pragma once

#include "native/space/cage/cage_triangles.h"

#include <vector>

namespace sinew {

using Polygons = std::vector<std::vector<int>>;

Polygons polygons(const std::vector<Triangle>& triangles);

/// Joins triangles of an embedded surface into quads, the squarest and flattest pairs first. A pair is joined
/// where the surface would be embedded and free of `within` along the other diagonal as well, whichever of
/// both somebody cuts the quad along. Quads and left triangles come in the order of their first triangle.
Polygons paired(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles,
                const TriangleTree& within);

} // namespace sinew
