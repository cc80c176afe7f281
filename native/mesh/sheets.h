// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/half_edges.h"
#include "native/mesh/surface_mesh.h"

#include <span>
#include <vector>

namespace sinew {

/// A connected part of a surface: faces joined through edges that two faces share.
struct Sheet
{
    std::vector<int> faces;   ///< the one of the lowest index first
    std::vector<char> turned; ///< (faces) whether each has to be flipped to agree with the first
    bool closed = true;       ///< whether each side of each face has a neighbour
    bool one_sided = false;   ///< whether the faces cannot all agree, as on a Moebius strip
};

/// The sheets of a mesh by their lowest faces. Cost: O(n).
///
/// \param sides  sorted_half_edges(mesh)
std::vector<Sheet> sheets(const SurfaceMesh& mesh, std::span<const HalfEdge> sides);

} // namespace sinew
