// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

namespace sinew {

/// The mesh with the sides of the whole: of faces that are joined by edges of two faces, those that lie the
/// other way round than the larger area of them are turned, so that a single flipped face changes nothing.
/// Surfaces of one side stay as they are, and so do the numbers of vertices and faces. Cost: O(n).
SurfaceMesh with_sides_of_the_whole(const SurfaceMesh& mesh);

} // namespace sinew
