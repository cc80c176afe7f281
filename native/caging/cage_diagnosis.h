// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace sinew {

/// What keeps a mesh from being a good cage. A good cage is closed, does not cross itself, looks outward, and
/// has its target inside.
struct CageDiagnosis
{
    std::vector<std::array<int, 2>> open_edges;         ///< edges with one face
    std::vector<std::array<int, 2>> non_manifold_edges; ///< edges with three or more faces
    /// Diagonals that are edges, too, or diagonals of several faces: more than two triangles meet there if
    /// faces are cut along them. Of a quad, this holds for both diagonals, of larger faces for those of
    /// SurfaceMesh.
    std::vector<std::array<int, 2>> crowded_diagonals;
    std::vector<int> inverted_faces; ///< faces that look inward and should be flipped
    std::vector<int> degenerate_faces; ///< faces with a triangle without area
    std::vector<std::array<int, 2>> crossing_faces; ///< pairs that meet elsewhere than at common corners
    std::vector<int> outside_points; ///< target points outside the cage
    int component_count = 0; ///< connected parts with faces
};

/// Faces are taken as the triangles that SurfaceMesh cuts them into. A part inside an odd number of other
/// parts is the wall of a cavity, and looks into it. A part that has no inside and outside (a Moebius strip)
/// has inverted faces. Points closer to the cage than 1e-9 of its size are not outside.
///
/// Cost: O(faces log faces + points * faces).
///
/// \param points  the points of the target; without them, only the cage is diagnosed.
/// \throw InvalidConstraint  a point is not finite.
CageDiagnosis diagnose_cage(const SurfaceMesh& cage, const std::optional<PointsView>& points = {});

/// One line with the number of each fault, or "clean".
std::string summary(const CageDiagnosis& diagnosis);

} // namespace sinew
