// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

#include <vector>

namespace sinew {

/// The connected parts of a mesh.
struct Components
{
    int count = 0;
    std::vector<int> labels; ///< (n) the part of each vertex; parts are numbered by their lowest vertices
};

/// Vertices are connected through faces; a vertex in no face is a part of its own. Cost: O(n).
Components connected_components(const SurfaceMesh& mesh);

} // namespace sinew
