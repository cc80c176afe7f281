// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

#include <array>
#include <string>
#include <vector>

namespace sinew {

/// What is unusual about a mesh, by element. Nothing of it prevents a bind.
struct Diagnosis
{
    std::vector<std::array<int, 2>> non_manifold_edges;  ///< edges of three or more faces
    std::vector<int> non_manifold_vertices;              ///< faces around it form more than one fan
    std::vector<std::vector<int>> boundary_loops;        ///< vertices in order along each border
    std::vector<int> degenerate_faces;                   ///< area below 1e-10 of its longest edge squared
    std::vector<int> duplicate_faces;                    ///< same vertices as an earlier face
    std::vector<std::array<int, 2>> inconsistent_edges;  ///< both faces run along it the same way
    std::vector<int> loose_vertices;                     ///< in no face
    std::vector<int> coincident_vertices;                ///< exactly where an earlier vertex is
    int component_count = 0;
};

/// O(n log n).
Diagnosis diagnose(const SurfaceMesh& mesh);

/// One line that names what is unusual with counts, or "clean".
std::string summary(const Diagnosis& diagnosis);

} // namespace sinew
