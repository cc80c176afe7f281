// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/mesh/remeshing/remeshed.h"
#include "native/mesh/surface_mesh.h"

#include <numbers>
#include <vector>

namespace sinew {

struct SemiRegularOptions
{
    int levels = 3; ///< 1 to 10 splits of each triangle into four
    /// Triangles of the base, >= 4. 0: so many that the last level has as many as the mesh, but at least 500, or
    /// a quarter of those of the mesh.
    int base_faces = 0;
    double angle = std::numbers::pi / 4; ///< radians, in (0, pi]; long folds that are sharper are kept
};

/// A surface as a base of few triangles, each of which is split into four several times.
struct SemiRegular
{
    /// The last level. The vertices of each level are its first ones; those of the base come first of all.
    Remeshed finest;
    std::vector<Triangle> base;
    std::vector<int> counts; ///< (levels + 1) vertices of each level
    /// (levels) for the new vertices of each level, how far they lie from the middle of the edge that they
    /// split. With the points of the base this is the whole surface.
    std::vector<std::vector<Vector3>> displacements;
};

/// Fits a subdivided base to a surface, as in M. Eck et al., "Multiresolution Analysis of Arbitrary Meshes",
/// SIGGRAPH 1995, and I. Guskov et al., "Normal Meshes", SIGGRAPH 2000.
///
/// The base comes from decimate(), which keeps borders, given edges and folds. Each level splits the edges in
/// the middle and puts the new vertices onto the surface: those on kept lines onto these, the others at the
/// closest point, or less far where a triangle would turn over. This departs from both papers, which parametrise
/// the surface over the base; where the base is too coarse for the shape, triangles may still fold there.
///
/// Cost: that of decimate(), and O(log n) for each vertex.
///
/// \param given  edges of the mesh that are kept, such as seams; others are ignored.
/// \throw InvalidMesh    no face has an area.
/// \throw InvalidOption  out of range, or more than 20 million triangles.
/// \throw Cancelled
SemiRegular semi_regular(const SurfaceMesh& mesh, const SemiRegularOptions& options,
                         const std::vector<Edge>& given = {}, const Progress& progress = {});

} // namespace sinew
