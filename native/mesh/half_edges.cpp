// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/half_edges.h"

#include "native/core/parallel.h"

#include <algorithm>
#include <numeric>

namespace sinew {

namespace {

template <class Visit>
void for_each_side(const SurfaceMesh& mesh, Visit&& visit)
{
    for (int f = 0; f < mesh.face_count(); ++f) {
        const auto loop = mesh.face(f);
        for (std::size_t k = 0; k < loop.size(); ++k) {
            const int a = loop[k];
            const int b = loop[(k + 1) % loop.size()];
            if (a != b)
                visit(HalfEdge{std::min(a, b), std::max(a, b), a, b, f});
        }
    }
}

} // namespace

std::vector<HalfEdge> sorted_half_edges(const SurfaceMesh& mesh)
{
    // They are counted into one bucket per lower vertex, and only these few are sorted.
    std::vector<int> begin(mesh.vertex_count() + 1, 0);
    for_each_side(mesh, [&](const HalfEdge& side) { ++begin[side.low + 1]; });
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<HalfEdge> sides(begin.back());
    std::vector<int> next(begin.begin(), begin.end() - 1);
    for_each_side(mesh, [&](const HalfEdge& side) { sides[next[side.low]++] = side; });
    parallel_for(mesh.vertex_count(), [&](int v) {
        std::sort(sides.begin() + begin[v], sides.begin() + begin[v + 1],
                  [](const HalfEdge& a, const HalfEdge& b) {
                      return std::array{a.high, a.face, a.from} < std::array{b.high, b.face, b.from};
                  });
    });
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
