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

// Other refusals are in tests/bindings/test_errors.py.
TEST(SurfaceMesh, refuses_counts_and_indices_that_no_array_of_python_has)
{
    constexpr int most = std::numeric_limits<int>::max(), least = std::numeric_limits<int>::min();
    refusal<InvalidMesh>(
        [&] { SurfaceMesh(shapes::points_of(corner), std::vector<int>(3, most), {0, 1, 2}); });
    for (int bad : {most, least})
        expect_elements(refusal<InvalidMesh>([&] { shapes::mesh(corner, {{0, 1, 2}, {0, 1, bad}}); }),
                        Error::Element::face, {1});
}

} // namespace sinew::test_surface_mesh
