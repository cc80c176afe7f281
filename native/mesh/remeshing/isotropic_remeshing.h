// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/mesh/remeshing/remeshed.h"
#include "native/mesh/surface_mesh.h"

#include <numbers>
#include <vector>

namespace sinew {

struct RemeshOptions
{
    /// Of edges at each vertex, more than 0; one: everywhere; none: the mean length of those of the triangles.
    std::vector<double> lengths{};
    int rounds = 3; ///< >= 1; each splits long edges, collapses short ones, flips and relaxes
    double angle = std::numbers::pi / 4; ///< radians, in (0, pi]; long folds that are sharper are kept
};

/// New triangles of even size and shape on the same surface.
///
/// M. Botsch, L. Kobbelt. "A Remeshing Approach to Multiresolution Modeling." Symposium on Geometry Processing
/// 2004, section 4: edges longer than 4/3 of the length are split, those shorter than 4/5 are collapsed, edges
/// are flipped towards six edges at each vertex, by CGAL, and vertices are relaxed along the surface and put
/// back onto it. P. Alliez et al. 2005 compare it with others. Between vertices the length is linear; of an
/// edge, the smaller of its ends counts.
///
/// Kept are the borders, the given edges, long folds sharper than the angle (see Manifold), and where such
/// lines end, meet or bend sharply: edges along them are only split and joined. A mesh that is no manifold is cut where it is none
/// (see Manifold) and joined again afterwards. Vertices without faces are left out.
///
/// Cost: O(n log n) in each round, of the triangles before and after; 86,000 take 5 s of processor time.
///
/// \param given  edges of the mesh that are kept, such as seams; others are ignored.
/// \throw InvalidMesh    no face has an area.
/// \throw InvalidOption  out of range, or lengths that would give more than 20 million triangles, or
/// split needles about 100 million times.
/// \throw Cancelled
Remeshed remesh(const SurfaceMesh& mesh, const RemeshOptions& options, const std::vector<Edge>& given = {},
                const Progress& progress = {});

} // namespace sinew
