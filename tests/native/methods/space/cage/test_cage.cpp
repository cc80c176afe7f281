// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/cage.h"

#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace sinew::test_cage {

namespace {

std::vector<int> named(const SurfaceMesh& mesh)
{
    return refusal<InvalidMesh>([&] { const Cage cage(mesh); }).elements();
}

} // namespace

TEST(Cage, takes_polygons_and_several_parts)
{
    EXPECT_NO_THROW(Cage{shapes::cube()});
    EXPECT_NO_THROW(Cage{shapes::joined(shapes::cube(), shapes::octahedron(), {5, 0, 0})});
}

TEST(Cage, names_the_vertices_of_open_edges)
{
    shapes::Polygons faces = shapes::faces_of(shapes::octahedron());
    const std::vector<int> lost(faces.back().begin(), faces.back().end());
    faces.pop_back();
    std::vector<int> expected = lost;
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(named(shapes::over(shapes::octahedron().points(), faces)), expected);
}

TEST(Cage, refuses_faces_that_look_to_different_sides)
{
    shapes::Polygons faces = shapes::faces_of(shapes::octahedron());
    std::reverse(faces.front().begin(), faces.front().end());
    EXPECT_EQ(named(shapes::over(shapes::octahedron().points(), faces)).size(), 3u);
}

TEST(Cage, refuses_one_inside_out_and_a_flat_one)
{
    shapes::Polygons faces = shapes::faces_of(shapes::cube());
    for (auto& face : faces)
        std::reverse(face.begin(), face.end());
    EXPECT_EQ(named(shapes::over(shapes::cube().points(), faces)).size(), 6u);
    Points flat = shapes::cube().points();
    flat.col(2).setZero();
    EXPECT_EQ(named(shapes::over(flat, shapes::faces_of(shapes::cube()))).size(), 6u);
}

TEST(Cage, refuses_no_faces) { EXPECT_THROW(Cage{SurfaceMesh(Points::Zero(3, 3), {}, {})}, InvalidMesh); }

TEST(Cage, names_the_vertices_of_a_pose_that_are_not_finite)
{
    const Cage cage(shapes::cube());
    Points pose = shapes::cube().points();
    EXPECT_NO_THROW(cage.check_pose(view(pose)));
    pose(3, 1) = std::numeric_limits<double>::quiet_NaN();
    expect_elements(refusal<InvalidConstraint>([&] { cage.check_pose(view(pose)); }), Error::Element::vertex,
                    {3});
    const Points few = pose.topRows(5);
    EXPECT_THROW(cage.check_pose(view(few)), InvalidConstraint);
}

} // namespace sinew::test_cage
