// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/primo/prisms.h"

#include "native/mesh/components.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_prisms {

namespace {

/// The prisms of a mesh with one handle.
Prisms with_handle(const SurfaceMesh& mesh, const std::vector<int>& held)
{
    const Regions regions({{held, {}}}, connected_components(mesh));
    return Prisms(mesh, regions, std::vector<double>(mesh.vertex_count(), 0.3));
}

/// Of the bodies, those that no handle holds.
int free_bodies(const Prisms& prisms)
{
    int count = 0;
    for (int b = 0; b < prisms.size(); ++b)
        count += prisms.handle(b) < 0;
    return count;
}

} // namespace

// What they cost is in tests/bindings/oracles/test_oracles_primo.py.
TEST(Prisms, a_prism_is_held_where_all_of_its_corners_are)
{
    const SurfaceMesh mesh = shapes::quad_grid(4, 4);
    const Prisms prisms = with_handle(mesh, {0, 1, 5, 6, 2});
    int vertices = 0;
    for (int b = 0; b < prisms.size(); ++b)
        vertices += prisms.is_vertex(b);
    EXPECT_EQ(vertices, 4); // all but vertex 0, which no free face has
    EXPECT_EQ(prisms.body_of(0), -1);
    EXPECT_EQ(prisms.size(), 16 + 4);
    EXPECT_EQ(free_bodies(prisms), 15); // all faces but 0, 1, 6, 5
}

TEST(Prisms, faces_that_share_only_a_vertex_hang_together)
{
    const SurfaceMesh bow =
        shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {0, 3, 4}});
    const Prisms prisms = with_handle(bow, {1});
    EXPECT_EQ(prisms.joints().size(), 2u); // that of both faces, and that of the held vertex
    EXPECT_EQ(free_bodies(prisms), 2);
}

TEST(Prisms, all_faces_at_an_edge_are_joined)
{
    std::vector<Vector3> points{{0, 0, 0}, {0, 0, 1}};
    shapes::Polygons faces;
    for (int k = 0; k < 4; ++k) {
        points.emplace_back(std::cos(1.5 * k), std::sin(1.5 * k), 0.5);
        faces.push_back({0, 1, 2 + k});
    }
    const SurfaceMesh fan = shapes::mesh(points, faces);
    EXPECT_EQ(with_handle(fan, {2}).joints().size(), 7u); // 6, and the vertex
}

} // namespace sinew::test_prisms
