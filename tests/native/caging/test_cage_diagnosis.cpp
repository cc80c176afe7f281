// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/caging/cage_diagnosis.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace sinew::test_cage_diagnosis {

namespace {

/// A box of half the size within the cube.
SurfaceMesh nested()
{
    return shapes::joined(shapes::cube(), shapes::moved(shapes::cube(), Points(shapes::cube().points() / 2)),
                          {.25, .25, .25});
}

} // namespace

TEST(CageDiagnosis, finds_nothing_in_a_good_cage)
{
    for (const SurfaceMesh& cage :
         {shapes::cube(), shapes::octahedron(), shapes::sphere(2), shapes::bar(6, 2)}) {
        const CageDiagnosis found = diagnose_cage(cage);
        EXPECT_EQ(summary(found), "clean");
        EXPECT_EQ(found.component_count, 1);
    }
}

TEST(CageDiagnosis, names_open_edges)
{
    const CageDiagnosis found = diagnose_cage(shapes::without_face(shapes::cube(), 1)); // 4 5 6 7
    EXPECT_EQ(found.open_edges, (std::vector<std::array<int, 2>>{{4, 5}, {4, 7}, {5, 6}, {6, 7}}));
    EXPECT_EQ(summary(found), "4 open edges");
}

TEST(CageDiagnosis, names_diagonals_that_are_edges_or_diagonals_of_other_faces)
{
    // Two faces of a tetrahedron as one quad: its other diagonal is the edge opposite.
    const std::vector<Vector3> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const SurfaceMesh quad = shapes::mesh(corners, {{0, 2, 1, 3}, {0, 3, 1}, {1, 2, 0}});
    CageDiagnosis found = diagnose_cage(quad);
    EXPECT_EQ(found.crowded_diagonals, (std::vector<std::array<int, 2>>{{0, 1}}));
    // A pillow of two quads has both diagonals twice, one of two pentagons those that it is cut along.
    for (int sides : {4, 5}) {
        std::vector<Vector3> rim;
        std::vector<int> front, back;
        for (int k = 0; k < sides; ++k) {
            rim.emplace_back(std::cos(2 * shapes::pi * k / sides), std::sin(2 * shapes::pi * k / sides), 0);
            front.push_back(k);
            back.insert(back.begin(), k);
        }
        found = diagnose_cage(shapes::mesh(rim, {front, back}));
        EXPECT_GE(found.crowded_diagonals.size(), 1u) << sides;
        EXPECT_NE(summary(found).find("more than two triangles"), std::string::npos);
    }
    EXPECT_TRUE(diagnose_cage(shapes::cube()).crowded_diagonals.empty());
}

TEST(CageDiagnosis, names_inverted_faces_one_or_all)
{
    const SurfaceMesh cube = shapes::cube();
    EXPECT_EQ(diagnose_cage(shapes::flipped(cube, {2, 4})).inverted_faces, (std::vector{2, 4}));
    EXPECT_EQ(diagnose_cage(shapes::flipped(cube, shapes::numbers(0, 6))).inverted_faces,
              shapes::numbers(0, 6));
    // Beside each other: each part for itself.
    const SurfaceMesh two = shapes::joined(cube, cube, {3, 0, 0});
    EXPECT_EQ(diagnose_cage(shapes::flipped(two, shapes::numbers(6, 12))).inverted_faces,
              shapes::numbers(6, 12));
    EXPECT_EQ(diagnose_cage(two).component_count, 2);
    // One in the other: the inner one is a cavity and has to look inward.
    EXPECT_EQ(diagnose_cage(nested()).inverted_faces, shapes::numbers(6, 12));
    EXPECT_EQ(summary(diagnose_cage(shapes::flipped(nested(), shapes::numbers(6, 12)))), "clean");
}

TEST(CageDiagnosis, names_crossing_and_degenerate_faces)
{
    const SurfaceMesh cube = shapes::cube();
    const CageDiagnosis found = diagnose_cage(shapes::joined(cube, cube, {.5, .5, .25}));
    // An edge of each cube goes through two faces of the other; every pair is of one face of each.
    EXPECT_GT(found.crossing_faces.size(), 4u);
    for (const auto& [f, g] : found.crossing_faces)
        EXPECT_TRUE(f < 6 && g >= 6);
    EXPECT_TRUE(found.open_edges.empty() && found.inverted_faces.empty());

    // An edge of the octahedron collapsed to a point: two flat faces.
    Points points = shapes::octahedron().points();
    points.row(4) = points.row(2);
    const CageDiagnosis flat = diagnose_cage(shapes::moved(shapes::octahedron(), points));
    EXPECT_EQ(flat.degenerate_faces, (std::vector{0, 1}));
}

TEST(CageDiagnosis, names_edges_of_three_faces)
{
    shapes::Polygons faces = shapes::faces_of(shapes::cube());
    faces.push_back({0, 1, 6});
    const CageDiagnosis found = diagnose_cage(shapes::over(shapes::cube().points(), faces));
    EXPECT_EQ(found.non_manifold_edges, (std::vector<std::array<int, 2>>{{0, 1}}));
    EXPECT_EQ(found.open_edges, (std::vector<std::array<int, 2>>{{0, 6}, {1, 6}}));
}

TEST(CageDiagnosis, names_points_outside)
{
    const Points points =
        shapes::points_of({{.5, .5, .5}, {1.5, .5, .5}, {1, 1, 1}, {1, .5, .5}, {.5, .5, 1 + 1e-6}});
    const CageDiagnosis found = diagnose_cage(shapes::cube(), view(points));
    EXPECT_EQ(found.outside_points, (std::vector{1, 4})); // on a corner or a face is not outside
    // No face: everything is outside.
    const CageDiagnosis none = diagnose_cage(shapes::mesh({{0, 0, 0}}, {}), view(points));
    EXPECT_EQ(none.outside_points.size(), 5u);
}

TEST(CageDiagnosis, of_many_loose_faces_takes_no_longer_than_of_one_part)
{
    std::vector<Vector3> points;
    shapes::Polygons faces;
    for (int f = 0; f < 20'000; ++f) {
        points.insert(points.end(), {Vector3(f, 0, 0), Vector3(f + .5, 0, 0), Vector3(f, .5, 0)});
        faces.push_back({3 * f, 3 * f + 1, 3 * f + 2});
    }
    const CageDiagnosis found = diagnose_cage(shapes::mesh(points, faces));
    EXPECT_EQ(found.open_edges.size(), 60'000u);
    EXPECT_EQ(found.component_count, 20'000);
    EXPECT_TRUE(found.crossing_faces.empty());
}

TEST(CageDiagnosis, survives_a_mesh_with_everything_wrong)
{
    const CageDiagnosis found = diagnose_cage(shapes::messy(), view(shapes::messy().points()));
    EXPECT_FALSE(found.open_edges.empty());
    EXPECT_FALSE(found.degenerate_faces.empty());
    EXPECT_FALSE(found.crossing_faces.empty()); // the doubled face
}

} // namespace sinew::test_cage_diagnosis
