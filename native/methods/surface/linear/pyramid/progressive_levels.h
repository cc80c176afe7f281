// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <vector>

namespace sinew {

/// One step of a progressive hierarchy: vertices that come back, no two of which are neighbours, and the
/// triangles of the level that they complete.
struct ProgressiveLevel
{
    std::vector<int> inserted; ///< ascending
    std::vector<Triangle> triangles;
};

/// A mesh that loses vertices level by level. The numbers of vertices are those of the mesh on all levels.
struct ProgressiveLevels
{
    std::vector<ProgressiveLevel> levels; ///< from coarse to fine
    std::vector<Triangle> coarsest;
};

/// Takes vertices out while there are more than `enough` that may go, and at most `most` times a set of
/// vertices that are no neighbours, those with the shortest edges first. The hole of each is filled by a fan
/// without folds and slivers. Triangles with a corner twice are left out unless they alone join a vertex to
/// others. A vertex stays if the faces around it are no disc or half a disc, and at corners of one triangle.
/// Cost: O(n log n) per level.
/// \param removable  (n) whether a vertex may go
ProgressiveLevels progressive_levels(const SurfaceMesh& mesh, std::vector<bool> removable, int most,
                                     int enough, const Progress& progress);

} // namespace sinew
