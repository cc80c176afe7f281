// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace sinew {

/// What keeps a mesh from being a good cage: closed, looking outward, embedded, around its target.
struct CageDiagnosis
{
    std::vector<std::array<int, 2>> open_edges;         ///< of one face
    std::vector<std::array<int, 2>> non_manifold_edges; ///< of three or more
    std::vector<int> inverted_faces;                    ///< look inward; turning them round mends the cage
    std::vector<int> degenerate_faces;                  ///< with a triangle of no area
    std::vector<std::array<int, 2>> crossing_faces;     ///< pairs that meet beside what they share
    std::vector<int> outside_points;                    ///< target points outside the cage
    int component_count = 0;                            ///< connected parts with faces
};

/// Faces are the triangles that SurfaceMesh cuts them into. A part inside an odd number of other parts is a
/// cavity and looks inward, into the hole. A part that has no inside and outside (Moebius) has inverted
/// faces. Points closer than 1e-9 of the cage's size to it are not outside.
///
/// \param points  none for the cage alone. Cost: faces log faces, and points times faces.
/// \throw InvalidConstraint  a point that is not finite.
CageDiagnosis diagnose_cage(const SurfaceMesh& cage, const std::optional<PointsView>& points = {});

/// One line that names what is wrong with counts, or "clean".
std::string summary(const CageDiagnosis& diagnosis);

} // namespace sinew
