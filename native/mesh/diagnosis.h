// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

#include <array>
#include <string>
#include <vector>

namespace sinew {

/// What is unusual about a mesh, as lists of elements. None of it prevents a bind.
struct Diagnosis
{
    std::vector<std::array<int, 2>> non_manifold_edges; ///< edges with three or more faces
    std::vector<int> non_manifold_vertices;             ///< vertices whose faces form more than one fan
    std::vector<std::vector<int>> boundary_loops;       ///< the vertices along each border, in order
    std::vector<int> degenerate_faces; ///< faces whose area is at most 1e-10 of their longest edge squared
    std::vector<int> duplicate_faces; ///< faces with the same vertices as an earlier face
    std::vector<std::array<int, 2>> inconsistent_edges; ///< edges along which both faces run the same way
    /// Faces that look to the wrong side, of each sheet (see mesh/sheets.h): of an open one the smaller part
    /// by area, of a closed one those that look inward. A closed one in the box around another closed one may
    /// be the wall of a cavity, so it is taken as an open one. None of a one-sided sheet, and none
    /// that is degenerate or a duplicate.
    std::vector<int> flipped_faces;
    std::vector<std::array<int, 2>> slit_edges; ///< borders exactly where another border is
    std::vector<int> loose_vertices; ///< vertices in no face
    std::vector<int> coincident_vertices; ///< vertices exactly where an earlier vertex is
    int component_count = 0;
    int one_sided_count = 0; ///< sheets that have no two sides, such as a Moebius strip
    int euler_characteristic = 0; ///< vertices with faces - edges + faces
};

/// Cost: O(n log n).
Diagnosis diagnose(const SurfaceMesh& mesh);

/// One line with the number of each unusual thing, or "clean".
std::string summary(const Diagnosis& diagnosis);

} // namespace sinew
