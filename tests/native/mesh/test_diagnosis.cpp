// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/diagnosis.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_diagnosis {

namespace {

using Edges = std::vector<std::array<int, 2>>;

/// Two triangles on the edge 0-1, one on each side.
const std::vector<Vector3> wing{{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, -1, 0}, {0.5, 0, 1}};

} // namespace

TEST(Diagnosis, finds_nothing_on_a_closed_surface)
{
    for (const SurfaceMesh& mesh :
         {shapes::cube(), shapes::octahedron(), shapes::sphere(2), shapes::bar(4, 2)}) {
        const Diagnosis found = diagnose(mesh);
        EXPECT_EQ(summary(found), "clean");
        EXPECT_TRUE(found.boundary_loops.empty());
        EXPECT_EQ(found.component_count, 1);
    }
}

TEST(Diagnosis, an_open_surface_is_clean_and_its_border_one_loop_in_order)
{
    const Diagnosis found = diagnose(shapes::quad_grid(2, 1));
    EXPECT_EQ(summary(found), "clean");
    ASSERT_EQ(found.boundary_loops.size(), 1u);
    EXPECT_EQ(found.boundary_loops[0], (std::vector{0, 1, 2, 5, 4, 3}));
}

TEST(Diagnosis, every_border_is_a_loop_of_its_own)
{
    // A 3 x 3 grid without its middle face: outer border of 12, inner of 4.
    const Diagnosis found = diagnose(shapes::without_face(shapes::quad_grid(3, 3), 4));
    ASSERT_EQ(found.boundary_loops.size(), 2u);
    EXPECT_EQ(found.boundary_loops[0].size(), 12u);
    EXPECT_EQ(found.boundary_loops[1].size(), 4u);
}

TEST(Diagnosis, finds_edges_of_three_faces)
{
    const Diagnosis found = diagnose(shapes::mesh(wing, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}));
    EXPECT_EQ(found.non_manifold_edges, (Edges{{0, 1}}));
    EXPECT_TRUE(found.inconsistent_edges.empty()); // three faces have no common orientation
}

TEST(Diagnosis, finds_vertices_where_fans_of_faces_touch)
{
    const SurfaceMesh hourglass =
        shapes::mesh({{0, 0, 0}, {1, 1, 0}, {1, -1, 0}, {-1, 1, 0}, {-1, -1, 0}}, {{0, 2, 1}, {0, 3, 4}});
    EXPECT_EQ(diagnose(hourglass).non_manifold_vertices, std::vector{0});
    // A fin touches along a whole edge: one fan at each of its ends.
    EXPECT_TRUE(
        diagnose(shapes::mesh(wing, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}})).non_manifold_vertices.empty());
}

TEST(Diagnosis, finds_faces_without_area)
{
    const std::vector<Vector3> p{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1e6, 1e-6, 0}};
    const Diagnosis found =
        diagnose(shapes::mesh(p, {{0, 1, 3}, {0, 1, 2}, {0, 0, 3}, {0, 1, 2, 3}, {0, 2, 4}}));
    // Number 4 has an area of 1e-6 under a longest edge of 1e6: 1e-18 of its square.
    EXPECT_EQ(found.degenerate_faces, (std::vector{1, 2, 4}));
}

TEST(Diagnosis, finds_faces_over_the_same_vertices_in_any_order)
{
    const Diagnosis found =
        diagnose(shapes::mesh(wing, {{0, 1, 2}, {1, 2, 0}, {1, 0, 3}, {2, 1, 0}, {0, 3, 1}}));
    EXPECT_EQ(found.duplicate_faces, (std::vector{1, 3, 4}));
}

TEST(Diagnosis, finds_edges_that_both_faces_run_the_same_way)
{
    const Diagnosis found = diagnose(shapes::mesh(wing, {{0, 1, 2}, {0, 1, 3}}));
    EXPECT_EQ(found.inconsistent_edges, (Edges{{0, 1}}));
    EXPECT_EQ(diagnose(shapes::flipped(shapes::cube(), {2})).inconsistent_edges,
              (Edges{{0, 1}, {0, 4}, {1, 5}, {4, 5}}));
}

TEST(Diagnosis, finds_loose_and_doubled_vertices)
{
    std::vector<Vector3> p = wing;
    p.push_back(wing[2]);
    p.push_back(wing[2]);
    const Diagnosis found = diagnose(shapes::mesh(p, {{0, 1, 2}, {1, 0, 3}, {0, 1, 5}}));
    EXPECT_EQ(found.loose_vertices, (std::vector{4, 6}));
    EXPECT_EQ(found.coincident_vertices, (std::vector{5, 6}));
    EXPECT_EQ(found.component_count, 3);
}

TEST(Diagnosis, counts_everything_in_one_messy_mesh)
{
    const Diagnosis found = diagnose(shapes::messy());
    EXPECT_EQ(found.duplicate_faces.size(), 1u);
    EXPECT_EQ(found.degenerate_faces.size(), 2u); // the needle has 1e-9 of its longest edge squared
    EXPECT_EQ(found.loose_vertices.size(), 1u);
    EXPECT_EQ(found.component_count, 3); // the hill, the triangle, the loose vertex
    EXPECT_FALSE(found.non_manifold_edges.empty());
}

TEST(Diagnosis, the_summary_counts_what_it_names)
{
    Diagnosis found;
    found.degenerate_faces = {1, 2};
    found.loose_vertices = {7};
    EXPECT_EQ(summary(found), "2 faces without area, 1 loose vertex");
    EXPECT_EQ(summary(Diagnosis{}), "clean");
}

TEST(Diagnosis, a_mesh_without_faces_is_all_loose)
{
    const Diagnosis found = diagnose(shapes::mesh({{0, 0, 0}, {1, 0, 0}}, {}));
    EXPECT_EQ(found.loose_vertices, (std::vector{0, 1}));
    EXPECT_EQ(found.component_count, 2);
}

} // namespace sinew::test_diagnosis
