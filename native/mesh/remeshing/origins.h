// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/mesh/remeshing/manifold.h"
#include "native/mesh/surface_mesh.h"

#include <array>
#include <vector>

namespace sinew {

/// Where the vertices, faces and corners of a new surface lie on an old one, so that whatever the old one
/// carries can be carried over: values of vertices and corners are interpolated, those of faces are copied.
///
/// A vertex lies at the closest point of the old surface, a face where its centroid does. The corners of a
/// face lie on the same side of the given lines as its centroid: the closest points there that can be reached
/// without crossing such a line. So each face has texture coordinates of one island.
struct Origins
{
    std::vector<Triangle> vertices; ///< (n) three old vertices, of a triangle
    std::vector<Vector3> vertex_weights; ///< (n) barycentric
    std::vector<int> faces;              ///< (m) the old face
    std::vector<Triangle> corners;       ///< (3 m) three old corners, counted face after face
    std::vector<Vector3> corner_weights; ///< (3 m) barycentric
    double farthest = 0.0; ///< distance of a vertex or centroid of either surface from the other one
    double mean = 0.0;     ///< the mean distance of the new vertices
};

/// Cost: O((n + m) log n).
///
/// \param given      edges of the old mesh that corners must not cross.
/// \throw InvalidMesh  no triangle of one of the surfaces has an area.
/// \throw Cancelled
Origins find_origins(const SurfaceMesh& mesh, const std::vector<Edge>& given,
                     const std::vector<Vector3>& points, const std::vector<Triangle>& triangles,
                     const Progress& progress);

/// Which of the lines is closest to each point, of equally close ones the first; -1 without lines.
std::vector<int> closest_lines(const std::vector<std::array<Vector3, 2>>& lines,
                               const std::vector<Vector3>& points);

/// The point of a segment that is closest to a point.
Vector3 closest_on(const std::array<Vector3, 2>& segment, const Vector3& point);

} // namespace sinew
