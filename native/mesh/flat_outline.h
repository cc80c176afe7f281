// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

#include <array>
#include <optional>
#include <vector>

namespace sinew {

/// The border of a mesh that lies in a plane.
struct FlatOutline
{
    Vector3 x, y, normal; ///< orthonormal; most faces are seen counter-clockwise from the side of the normal
    std::vector<std::array<int, 2>> edges; ///< (a, b), the inside is to the left of a -> b
};

/// The outline of a flat mesh; none if a vertex is farther from a plane than 1e-5 of the size, or the mesh
/// has no border or no area. It may have several loops, also around holes; vertices inside are on none.
///
/// \throw InvalidMesh  neighbouring faces look to different sides; or two edges of the outline cross, or more
///   than two meet. The vertices of such edges are named.
std::optional<FlatOutline> flat_outline(const SurfaceMesh& mesh);

} // namespace sinew
