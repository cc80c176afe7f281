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
    std::vector<Line> lines; ///< borders, given edges, and the folds of keep_lines(), each edge once, sorted
    double area = 0.0; ///< of all triangles
    double mean_edge = 0.0; ///< the mean length of the edges; those that were cut count once for each side
    std::vector<char> stays; ///< (points) where lines end, meet or bend by more than 75 degrees

    /// Cost: O(n log n).
    /// \param given  (k) edges of the mesh; others are ignored.
    /// \throw InvalidMesh  no face has an area.
    Manifold(const SurfaceMesh& mesh, const std::vector<Edge>& given);

    /// Adds folds to the lines, and finds the points that stay. Connected folds that are together shorter than
    /// ten edges of the mesh, or of those that are asked for, are no features of the shape, but its roughness:
    /// they are left out. Cost: O(n log n).
    /// \param angle   radians between the normals at a fold, in (0, pi].
    /// \param length  of the edges that are asked for.
    /// \throw InvalidOption  the angle is out of range.
    void keep_lines(double angle, double length);

    /// The triangles with a vertex for each side of the lines at it, numbered as they come.
    std::vector<Triangle> parted_at_lines() const;
};

} // namespace sinew
