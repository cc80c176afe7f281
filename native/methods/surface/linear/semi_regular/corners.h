// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

#include <vector>

namespace sinew {

/// The corners of all faces, one after the other, and which of them meet across edges. Corner c is at
/// vertex[c] and stands for the side from there to vertex[next(c)]. Faces of one vertex repeated are no faces
/// and have no corners here.
struct JoinedCorners
{
    static constexpr int none = -1;

    std::vector<int> first; ///< (faces + 1) the first corner of each face
    std::vector<int> vertex, face;
    std::vector<int> twin;  ///< the corner of the side that runs back; none at borders
    std::vector<int> at;    ///< (n) the lowest corner of each vertex; none where it has no face
    std::vector<int> count; ///< (n) the faces of each vertex

    /// \param part   (n) the part of each vertex.
    /// \param[in,out] sound  (parts) 1 for the parts whose corners are to be joined; 0 afterwards where a
    ///   part has faces of a size besides 3 or of a size besides 4, a face with a corner twice, more than two
    ///   faces at an edge or two of opposite orientations, or a vertex that joins several fans of faces.
    JoinedCorners(const SurfaceMesh& mesh, const std::vector<int>& part, std::vector<char>& sound);

    int next(int c) const { return c + 1 < first[face[c] + 1] ? c + 1 : first[face[c]]; }
    int previous(int c) const { return c > first[face[c]] ? c - 1 : first[face[c] + 1] - 1; }
    int across(int c) const { return next(next(c)); } ///< of a quad

    /// The corners at a vertex, counterclockwise, from border to border.
    /// \return whether they close a circle.
    bool fan(int v, std::vector<int>& corners) const;
};

} // namespace sinew
