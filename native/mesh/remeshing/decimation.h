// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/mesh/remeshing/remeshed.h"
#include "native/mesh/surface_mesh.h"

#include <numbers>
#include <vector>

namespace sinew {

struct DecimateOptions
{
    int faces = 1000; ///< triangles wanted, >= 4
    double angle = std::numbers::pi / 4; ///< radians, in (0, pi]; long folds that are sharper are kept
};

/// Fewer triangles for the same surface.
///
/// P. Lindstrom, G. Turk. "Fast and Memory Efficient Polygonal Simplification." IEEE Visualization 1998, by
/// CGAL: the edge whose collapse changes shape and volume least is collapsed, until so many triangles are left
/// or no edge can be collapsed without turning a triangle over.
///
/// Kept are the borders, the given edges, long folds sharper than the angle (see Manifold), and where such
/// lines end, meet or bend sharply: edges along a line are collapsed onto it, edges beside it towards it, and no edge between two lines
/// is. A mesh that is no manifold is cut and joined as for remesh().
///
/// Cost: O(n log n).
///
/// \param given  edges of the mesh that are kept, such as seams; others are ignored.
/// \throw InvalidMesh    no face has an area.
/// \throw InvalidOption  out of range.
/// \throw Cancelled
Remeshed decimate(const SurfaceMesh& mesh, const DecimateOptions& options,
                  const std::vector<Edge>& given = {}, const Progress& progress = {});

/// The same without origins and `sources`, from a manifold that is kept, whose lines are found first.
Remeshed decimated(Manifold& cut, int faces, double angle, const Progress& progress);

} // namespace sinew
