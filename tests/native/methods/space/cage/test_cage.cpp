// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/cage.h"

#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

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

TEST(Cage, names_what_is_wrong)
{
    Points flat = shapes::cube().points();
    flat.col(2).setZero();
    EXPECT_EQ(named(shapes::without_face(shapes::octahedron(), 7)), (std::vector{0, 3, 5})) << "open";
    EXPECT_EQ(named(shapes::flipped(shapes::octahedron(), {0})).size(), 3u);
    EXPECT_EQ(named(shapes::inside_out(shapes::cube())).size(), 6u);
    EXPECT_EQ(named(shapes::moved(shapes::cube(), flat)).size(), 6u);
    EXPECT_THROW(Cage{SurfaceMesh(Points::Zero(3, 3), {}, {})}, InvalidMesh) << "no faces";
}

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
