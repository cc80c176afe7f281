// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"
#include "native/mesh/trees/triangle_tree.h"
#include "native/methods/surface/sketch/silhouette_lines.h"

#include <vector>

namespace sinew {

/// Tells which points of lines on a mesh the mesh itself hides from the viewer.
///
/// A point is hidden if the way to the viewer meets a face. The first two edge lengths of the way do not
/// count, by the longest edges around the point: there the faces around a silhouette, along which one looks,
/// may lie before it. So small folds hide nothing.
///
///   call         cost
///   constructor  O(n log n)
///   hides()      O(log n)
class Occlusion
{
public:
    Occlusion(const SurfaceMesh& mesh, const SketchView& view);

    bool hides(const LinePoint& point) const;

private:
    const SurfaceMesh& mesh_;
    SketchView view_;
    TriangleTree tree_;
    std::vector<double> longest_; ///< (n) edge at each vertex
    double beyond_;               ///< a length that leads out of the mesh from everywhere in it
};

} // namespace sinew
