// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

#include <vector>

namespace sinew {

struct Components
{
    int count = 0;
    std::vector<int> labels; ///< (n) part of each vertex, numbered by lowest vertex
};

/// Parts connected through faces; a vertex of no face is a part of its own. O(n).
Components connected_components(const SurfaceMesh& mesh);

} // namespace sinew
