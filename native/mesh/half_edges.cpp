// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/half_edges.h"

#include <algorithm>

namespace sinew {

std::vector<HalfEdge> sorted_half_edges(const SurfaceMesh& mesh)
{
    std::vector<HalfEdge> sides;
    for (int f = 0; f < mesh.face_count(); ++f) {
        const auto loop = mesh.face(f);
        for (std::size_t k = 0; k < loop.size(); ++k) {
            const int a = loop[k];
            const int b = loop[(k + 1) % loop.size()];
            if (a != b)
                sides.push_back({std::min(a, b), std::max(a, b), a, b, f});
        }
    }
    std::ranges::sort(sides, {}, [](const HalfEdge& s) { return std::array{s.low, s.high, s.face, s.from}; });
    return sides;
}

std::vector<bool> border_vertices(const SurfaceMesh& mesh)
{
    std::vector<bool> border(mesh.vertex_count(), false);
    const std::vector<HalfEdge> sorted = sorted_half_edges(mesh);
    for_each_edge(sorted, [&](std::span<const HalfEdge> sides) {
        if (sides.size() == 1)
            border[sides[0].low] = border[sides[0].high] = true;
    });
    return border;
}

} // namespace sinew
