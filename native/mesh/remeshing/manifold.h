// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <array>
#include <vector>

namespace sinew {

using Edge = std::array<int, 2>;

/// The triangles of a mesh such that each edge has at most two, which look the same way, and the triangles
/// around each vertex are one fan; with the lines that remeshing keeps.
///
/// Where a mesh has edges of three or more faces, several fans at a vertex or opposed faces, it is cut: such
/// vertices are there several times. Vertices without faces, faces with the same vertices as an earlier one
/// and triangles with a repeated corner are left out. Most faces of each sheet keep their side.
struct Manifold
{
    struct Line
    {
        Edge edge;      ///< of `points`
        int given = -1; ///< which of the given edges it is; -1 for borders, cuts and folds
        bool cut = false;
    };

    std::vector<Vector3> points;
    std::vector<Triangle> triangles;
    std::vector<int> originals; ///< (points) the vertex of the mesh
    std::vector<Line> lines; ///< given ones, borders, and folds sharper than `angle`, each edge once
    double area = 0.0;       ///< of all triangles
    std::vector<char> stays; ///< (points) where lines end, meet or bend by more than 75 degrees

    /// Cost: O(n log n).
    /// \param given  (k) edges of the mesh; others are ignored.
    /// \param angle  radians between the normals at a fold, in (0, pi].
    /// \throw InvalidMesh    no face has an area.
    /// \throw InvalidOption  the angle is out of range.
    Manifold(const SurfaceMesh& mesh, const std::vector<Edge>& given, double angle);
};

/// The mean length of the edges of the triangles; those that were cut count once for each side.
double mean_edge_length(const Manifold& manifold);

} // namespace sinew
