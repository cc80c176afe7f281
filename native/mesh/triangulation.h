// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

#include <span>
#include <vector>

namespace sinew {

/// Appends the k - 2 triangles of one polygon of k >= 3 corners, oriented as the polygon. Concave and
/// non-planar polygons are cut in the plane of their area vector, the best-shaped ear first. A polygon may
/// have holes that slits join to its outline. One without any ear (which crosses itself, or lies on a line)
/// is still cut into k - 2 triangles with its corners. Cost: O(k^2), and O(k^3) where most corners are no
/// ears.
void triangulate(const Points& points, std::span<const int> polygon, std::vector<Triangle>& triangles);

} // namespace sinew
