// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/mesh/remeshing/remeshed.h"
#include "native/mesh/surface_mesh.h"

#include <numbers>
#include <vector>

namespace sinew {

struct DegenerateOptions
{
    double ratio = 4.0; ///< > 1; of the longest side to the shortest one: triangles above it are needles
    double cap = 160.0 / 180.0 * std::numbers::pi; ///< radians, in (pi / 2, pi]; of the angle of caps
    double share = 0.2; ///< > 0; needles whose shortest side is below this share of the mean edge go
    double angle = std::numbers::pi / 4; ///< radians, in (0, pi]; folds that are sharper are kept
};

/// The triangles of a surface without needles, which have one very short side, and caps, which have one very
/// wide angle.
///
/// M. Botsch, L. Kobbelt. "A Robust Procedure to Eliminate Degenerate Faces from Triangle Meshes." VMV 2001,
/// by CGAL, which collapses the short sides of needles and flips the long sides of caps. Borders, given edges
/// and sharp folds stay, with their ends: so do the needles between them. A mesh that is no manifold is cut and
/// joined as for remesh().
///
/// Cost: O(n log n).
///
/// \param given  edges of the mesh that are kept, such as seams; others are ignored.
/// \throw InvalidMesh    no face has an area.
/// \throw InvalidOption  out of range.
/// \throw Cancelled      before or after the triangles are removed.
Remeshed remove_degenerate(const SurfaceMesh& mesh, const DegenerateOptions& options,
                           const std::vector<Edge>& given = {}, const Progress& progress = {});

} // namespace sinew
