// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/surface_mesh.h"

#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <limits>

namespace sinew::test_surface_mesh {

namespace {

const std::vector<Vector3> corner{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

} // namespace

TEST(SurfaceMesh, keeps_points_and_faces_as_given)
{
    const SurfaceMesh mesh = shapes::cube();
    EXPECT_EQ(mesh.vertex_count(), 8);
    EXPECT_EQ(mesh.face_count(), 6);
    EXPECT_EQ(mesh.point(6), Vector3(1, 1, 1));
    EXPECT_EQ(shapes::faces_of(mesh)[2], (std::vector{0, 1, 5, 4}));
}

TEST(SurfaceMesh, cuts_a_face_of_k_corners_into_k_minus_2_triangles)
{
    const SurfaceMesh mesh = shapes::mesh({{0, 0, 0}, {1, 0, 0}, {2, 1, 0}, {1, 2, 0}, {0, 2, 0}, {-1, 1, 0}},
                                          {{0, 1, 2}, {0, 2, 3, 4}, {0, 1, 2, 3, 4, 5}});
    EXPECT_EQ(mesh.triangle_faces(), (std::vector{0, 1, 1, 2, 2, 2, 2}));
    EXPECT_EQ(mesh.triangles().size(), 7u);
    EXPECT_EQ(mesh.triangles()[0], (Triangle{0, 1, 2}));
}

TEST(SurfaceMesh, edges_are_those_of_the_faces_without_the_cuts)
{
    EXPECT_EQ(shapes::cube().edges().size(), 12u);
    EXPECT_EQ(shapes::octahedron().edges().size(), 12u);
    const auto edges = shapes::quad_grid(1, 1).edges();
    EXPECT_EQ(edges, (std::vector<std::array<int, 2>>{{0, 1}, {0, 2}, {1, 3}, {2, 3}}));
}

TEST(SurfaceMesh, may_have_no_faces)
{
    const SurfaceMesh mesh = shapes::mesh(corner, {});
    EXPECT_EQ(mesh.face_count(), 0);
    EXPECT_TRUE(mesh.triangles().empty());
    EXPECT_TRUE(mesh.edges().empty());
}

TEST(SurfaceMesh, accepts_doubled_faces_repeated_corners_and_loose_vertices)
{
    const SurfaceMesh mesh = shapes::messy();
    EXPECT_EQ(mesh.triangles().size(), static_cast<std::size_t>(mesh.face_count()));
}

TEST(SurfaceMesh, refuses_a_mesh_without_vertices)
{
    refusal<InvalidMesh>([] { SurfaceMesh(Points(0, 3), {}, {}); });
}

TEST(SurfaceMesh, refuses_points_that_are_not_finite_and_names_them)
{
    for (double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                       -std::numeric_limits<double>::infinity()}) {
        Points points = shapes::points_of(corner);
        points(1, 2) = bad;
        expect_elements(refusal<InvalidMesh>([&] { shapes::over(points, {{0, 1, 2}}); }),
                        Error::Element::vertex, {1});
    }
}

TEST(SurfaceMesh, refuses_faces_of_fewer_than_three_corners_and_names_them)
{
    expect_elements(refusal<InvalidMesh>([] { shapes::mesh(corner, {{0, 1, 2}, {0, 1}, {0, 1, 2}, {}}); }),
                    Error::Element::face, {1, 3});
}

TEST(SurfaceMesh, refuses_indices_out_of_range_and_names_their_faces)
{
    for (int bad : {3, -1, std::numeric_limits<int>::max(), std::numeric_limits<int>::min()}) {
        expect_elements(refusal<InvalidMesh>([&] { shapes::mesh(corner, {{0, 1, 2}, {0, 1, bad}}); }),
                        Error::Element::face, {1});
    }
}

TEST(SurfaceMesh, refuses_counts_that_do_not_add_up)
{
    const Points points = shapes::points_of(corner);
    refusal<InvalidMesh>([&] { SurfaceMesh(points, {3}, {0, 1, 2, 0}); });
    refusal<InvalidMesh>([&] { SurfaceMesh(points, {3, 3}, {0, 1, 2}); });
    refusal<InvalidMesh>([&] { SurfaceMesh(points, {-3, 6}, {0, 1, 2}); });
    refusal<InvalidMesh>(
        [&] { SurfaceMesh(points, std::vector<int>(3, std::numeric_limits<int>::max()), {0, 1, 2}); });
}

} // namespace sinew::test_surface_mesh
