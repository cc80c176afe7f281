// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/trees/crossing_faces.h"

#include "native/mesh/trees/triangle_tree.h"

#include <algorithm>

namespace sinew {

std::vector<std::array<int, 2>> crossing_faces(const SurfaceMesh& mesh, const std::vector<Vector3>& points)
{
    std::vector<std::array<int, 2>> pairs;
    for (const auto& [s, t] : meeting_pairs(points, mesh.triangles())) {
        const auto [f, g] = std::minmax(mesh.triangle_faces()[s], mesh.triangle_faces()[t]);
        if (f != g)
            pairs.push_back({f, g});
    }
    std::ranges::sort(pairs);
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    return pairs;
}

} // namespace sinew
