// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <array>
#include <vector>

namespace sinew {

/// Corner k of a cell lies at the local place (k & 1, k >> 1 & 1, k >> 2).
using Hexahedron = std::array<int, 8>;

/// The cells of a mesh: eight vertices each, whose six sides are quads of the mesh. A quad between two cells
/// is one face of the mesh. Cost: O(faces).
std::vector<Hexahedron> find_hexahedra(const SurfaceMesh& mesh);

/// Cells cut in eight, by weights of the vertices that they came from.
struct RefinedCells
{
    std::vector<Hexahedron> cells;
    Eigen::SparseMatrix<double, Eigen::RowMajor> weights; ///< (refined vertices, vertices)
};

/// One step of subdivision of a solid. R. MacCracken, K. I. Joy. "Free-Form Deformations With Lattices of
/// Arbitrary Topology." SIGGRAPH 1996.
///
/// The border is a Catmull-Clark surface; edges in one cell only are creases, and vertices in one cell only
/// stay, so that a box remains a box.
RefinedCells refined(const std::vector<Hexahedron>& cells, int vertices);

} // namespace sinew
