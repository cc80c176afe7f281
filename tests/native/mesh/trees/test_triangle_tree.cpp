// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/trees/triangle_tree.h"

#include "tests/native/shapes.h"

#include <limits>

namespace sinew::test_triangle_tree {

const Corners base{Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0)};
const Triangle base_indices{0, 1, 2};

bool meets_base(const Corners& other, const Triangle& indices)
{
    const bool found = triangles_meet(base, base_indices, other, indices);
    EXPECT_EQ(triangles_meet(other, indices, base, base_indices), found); // both ways round
    return found;
}

TEST(CageTriangles, meet_beside_what_they_share)
{
    const double least = std::numeric_limits<double>::denorm_min();
    // Nothing in common: through, above by the smallest number there is, touching.
    EXPECT_TRUE(meets_base({Vector3(.2, .2, -1), Vector3(.2, .2, 1), Vector3(2, 2, 0)}, {3, 4, 5}));
    EXPECT_FALSE(meets_base({Vector3(.2, .2, least), Vector3(.2, .3, 1), Vector3(2, 2, 1)}, {3, 4, 5}));
    EXPECT_TRUE(meets_base({Vector3(.25, .25, 0), Vector3(.2, .3, 1), Vector3(2, 2, 1)}, {3, 4, 5}));
    // A corner: apart, in the same plane apart, in the same plane over one another, through.
    EXPECT_FALSE(meets_base({base[0], Vector3(1, 0, 1), Vector3(0, 1, 1)}, {0, 4, 5}));
    EXPECT_FALSE(meets_base({base[0], Vector3(-1, 0, 0), Vector3(0, -1, 0)}, {0, 4, 5}));
    EXPECT_TRUE(meets_base({base[0], Vector3(.2, .1, 0), Vector3(.1, .2, 0)}, {0, 4, 5}));
    EXPECT_TRUE(meets_base({base[0], Vector3(1, 1, 1), Vector3(1, 1, -1)}, {0, 4, 5}));
    // An edge: flat on, side by side, folded by the smallest number.
    EXPECT_TRUE(meets_base({base[1], base[0], Vector3(.3, .4, 0)}, {1, 0, 5}));
    EXPECT_FALSE(meets_base({base[1], base[0], Vector3(.3, -.4, 0)}, {1, 0, 5}));
    EXPECT_FALSE(meets_base({base[1], base[0], Vector3(.3, .4, least)}, {1, 0, 5}));
    EXPECT_TRUE(meets_base(base, base_indices));
}

TEST(CageTriangles, pairs_are_those_of_all_against_all)
{
    shapes::Random random(3);
    std::vector<Vector3> points;
    std::vector<Triangle> triangles;
    for (int t = 0; t < 120; ++t) {
        const Vector3 at = random.vector();
        for (int k = 0; k < 3; ++k)
            points.push_back(at + 0.3 * random.vector());
        triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    triangles.push_back({0, 0, 1}); // flat: left out
    std::vector<std::array<int, 2>> expected;
    for (int s = 0; s < 120; ++s)
        for (int t = s + 1; t < 120; ++t)
            if (triangles_meet(corners_of(points, triangles[s]), triangles[s],
                               corners_of(points, triangles[t]), triangles[t]))
                expected.push_back({s, t});
    EXPECT_GT(expected.size(), 10u);
    EXPECT_EQ(meeting_pairs(points, triangles), expected);
}

TEST(TriangleTree, names_the_triangle_of_the_closest_point_and_whether_one_is_met)
{
    const SurfaceMesh cube = shapes::cube();
    const TriangleTree sides(shapes::list_of(cube.points()), cube.triangles());
    EXPECT_TRUE(sides.meets({Vector3(.5, .5, .5), Vector3(.5, .5, 2), Vector3(.6, .5, .5)}));
    EXPECT_FALSE(sides.meets({Vector3(.5, .5, .5), Vector3(.5, .5, .9), Vector3(.6, .5, .5)}));
    EXPECT_FALSE(sides.meets({Vector3(0, 0, 0), Vector3(0, 0, 0), Vector3(1, 0, 0)})); // flat
    const SurfaceMesh mesh = shapes::sphere(2);
    std::vector<Triangle> triangles{{0, 0, 1}, {2, 2, 2}}; // flat: left out, but counted
    triangles.insert(triangles.end(), mesh.triangles().begin(), mesh.triangles().end());
    const std::vector<Vector3> points = shapes::list_of(mesh.points());
    const TriangleTree tree(points, triangles);
    for (int t = 2; t < static_cast<int>(triangles.size()); ++t) {
        const Corners corners = corners_of(points, triangles[t]);
        const Vector3 middle = (corners[0] + corners[1] + corners[2]) / 3;
        const TriangleTree::Place found = tree.closest_place(1.5 * middle);
        EXPECT_EQ(found.triangle, t);
        EXPECT_EQ(found.point, tree.closest(1.5 * middle));
        EXPECT_LT((found.point - middle).norm(), .05);
    }
    EXPECT_FALSE(tree.empty());
    EXPECT_TRUE(TriangleTree(points, {Triangle{0, 0, 1}}).empty());
    EXPECT_TRUE(TriangleTree(points, {}).empty());
}

TEST(TriangleTree, counts_the_crossings_of_a_ray_as_often_as_the_surface_winds_around_a_point)
{
    const SurfaceMesh mesh = shapes::sphere(2);
    const std::vector<Vector3> points = shapes::list_of(mesh.points());
    std::vector<Triangle> triangles = mesh.triangles();
    const Vector3 direction(.5357, .6301, .5622);
    shapes::Random random(5);
    // All but one of six equal faces, seen from the middle.
    const std::vector<Vector3> cube = shapes::list_of(shapes::cube().points());
    std::vector<Triangle> open = shapes::cube().triangles();
    open.resize(10);
    EXPECT_NEAR(winding_number(cube, open, {.5, .5, .5}), 5.0 / 6.0, 1e-14);
    for (int sign : {1, -1}) {
        const TriangleTree tree(points, triangles);
        for (int k = 0; k < 200; ++k) {
            const Vector3 at = 1.5 * random.vector();
            const double wound = winding_number(points, triangles, at);
            EXPECT_EQ(tree.crossings(at, direction), std::lround(wound)) << at.transpose();
            EXPECT_EQ(std::lround(wound), at.norm() < .9 ? sign : at.norm() > 1 ? 0 : std::lround(wound));
        }
        for (Triangle& t : triangles)
            std::swap(t[1], t[2]);
    }
}

} // namespace sinew::test_triangle_tree
