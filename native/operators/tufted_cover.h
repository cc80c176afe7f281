// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

#include <array>
#include <optional>
#include <vector>

namespace sinew {

/// Triangles that have only lengths: their sides are the shortest ways over a surface, and need not be edges.
struct IntrinsicTriangles
{
    std::vector<Triangle> triangles; ///< vertices; two of them may be the same one
    std::vector<std::array<double, 3>> lengths; ///< of the sides from corner k to the next one
};

/// The intrinsic Delaunay triangulation of the surface that lies on both sides of every triangle of a mesh.
///
/// N. Sharp, K. Crane. "A Laplacian for Nonmanifold Triangle Meshes." Symposium on Geometry Processing 2020.
/// A. I. Bobenko, B. A. Springborn. "A Discrete Laplace-Beltrami Operator for Simplicial Surfaces." Discrete
/// and Computational Geometry 38(4), 2007.
///
/// Each triangle becomes two, back to back, and around an edge each is glued to the one that it faces, so
/// that every edge has two sides: also a border, where front and back meet, and an edge with many faces. Sides
/// whose opposite angles have a sum above pi are turned over, until there are none left.
///
/// Before, all lengths grow by the least amount after which no triangle is closer to a line than by 1e-5 of
/// the mean length (section 4.5 of the first paper): by none, unless there are slivers.
///
/// Cost: O(n log n), and a turn for some of the sides: one in fourteen of an irregular mesh.
///
/// \return nothing where no length grew and no side was turned: these would be the triangles of the mesh twice.
std::optional<IntrinsicTriangles> delaunay_cover(const SurfaceMesh& mesh);

} // namespace sinew
