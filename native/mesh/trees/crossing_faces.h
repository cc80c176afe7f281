// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <array>
#include <vector>

namespace sinew {

/// The pairs (i < j) of faces that have more points in common than the corners and edges that they share by
/// index, ascending: where a surface passes through itself, touches itself, or is folded onto itself. Exact.
/// Faces are taken as the triangles that SurfaceMesh cuts them into; triangles without area are left out.
/// Cost: that of meeting_pairs().
///
/// \param points  those of the mesh, in any unit; none smaller than 1e-150 but 0 (see points_in_unit).
std::vector<std::array<int, 2>> crossing_faces(const SurfaceMesh& mesh, const std::vector<Vector3>& points);

} // namespace sinew
