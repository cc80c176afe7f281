// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/edge_distances.h"

#include "tests/native/shapes.h"

namespace sinew::test_edge_distances {

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(EdgeDistances, are_those_of_all_ways)
{
    const SurfaceMesh mesh = shapes::messy();
    const int n = mesh.vertex_count();
    MatrixX ways = MatrixX::Constant(n, n, infinity); // R. W. Floyd 1962
    ways.diagonal().setZero();
    for (const Triangle& t : mesh.triangles())
        for (int k = 0; k < 3; ++k) {
            const int a = t[k], b = t[(k + 1) % 3];
            ways(a, b) = ways(b, a) = std::min(ways(a, b), (mesh.point(a) - mesh.point(b)).norm());
        }
    for (int k = 0; k < n; ++k)
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j)
                ways(i, j) = std::min(ways(i, j), ways(i, k) + ways(k, j));
    const EdgeDistances edges(shapes::list_of(mesh.points()), mesh.triangles());
    for (int v : {0, 40, n - 1}) {
        const std::vector<double> all = edges.from(v), near = edges.from(v, 3.0);
        for (int u = 0; u < n; ++u) {
            EXPECT_TRUE(all[u] == ways(v, u) || std::abs(all[u] - ways(v, u)) < 1e-13) << u;
            EXPECT_EQ(near[u], all[u] <= 3.0 ? all[u] : infinity);
        }
    }
}

} // namespace sinew::test_edge_distances
