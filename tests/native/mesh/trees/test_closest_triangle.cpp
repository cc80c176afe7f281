// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/trees/closest_triangle.h"

#include "native/mesh/trees/triangle_tree.h"
#include "tests/native/shapes.h"

#include <limits>

namespace sinew::test_closest_triangle {

constexpr double anywhere = std::numeric_limits<double>::infinity();

struct Soup
{
    Points points;
    std::vector<Triangle> triangles;

    double squared(const Vector3& x, int t) const
    {
        const auto [i, j, k] = triangles[t];
        return squared_distance(x, points.row(i).transpose(), points.row(j).transpose(),
                                points.row(k).transpose());
    }
};

/// Triangles that cross each other, of all sizes, some of them flat, some of them twice.
Soup soup(int count)
{
    shapes::Random random(7);
    Soup made{random.dense(3 * count, 3), {}};
    for (int t = 0; t < count; ++t) {
        const int v = 3 * t;
        const double size = std::pow(10.0, -(t % 5));
        for (int k : {1, 2})
            made.points.row(v + k) = made.points.row(v) + size * made.points.row(v + k);
        if (t % 11 == 0)
            made.points.row(v + 2) = 0.5 * (made.points.row(v) + made.points.row(v + 1));
        if (t % 13 == 0)
            made.points.row(v + 1) = made.points.row(v + 2);
        made.triangles.push_back({v, v + 1, v + 2});
        if (t % 7 == 0)
            made.triangles.push_back({v, v + 1, v + 2});
    }
    return made;
}

TEST(ClosestTriangle, is_that_of_the_tree_in_a_soup)
{
    const Soup made = soup(400);
    const std::vector<Vector3> points = shapes::list_of(made.points);
    const TriangleTree tree(points, made.triangles);
    const ClosestTriangle closest(view(made.points), made.triangles);
    shapes::Random random(8);
    const Points from = 1.5 * random.dense(300, 3);
    for (int i = 0; i < from.rows(); ++i) {
        const Vector3 x = from.row(i).transpose();
        const TriangleTree::Place place = tree.closest_place(x);
        const double distance = (place.point - x).norm();
        const int found = closest.to(x, anywhere);
        ASSERT_GE(found, 0);
        // Slivers cost the projection of either some digits.
        EXPECT_NEAR(std::sqrt(made.squared(x, found)), distance, 1e-9);
        EXPECT_EQ(closest.to(x, distance + 1e-8), found);
        EXPECT_EQ(closest.to(x, distance - 1e-8), -1);
        for (int t = 0; t < found; ++t) // of equal ones the first, by the same arithmetic
            if (!is_flat(corners_of(points, made.triangles[t]))) {
                ASSERT_GT(made.squared(x, t), made.squared(x, found));
            }
    }
}

TEST(ClosestTriangle, is_that_of_the_tree_on_a_surface)
{
    const SurfaceMesh mesh = shapes::hill(30, 20);
    shapes::Random random(9);
    const Soup made{mesh.points() + 0.02 * random.dense(mesh.vertex_count(), 3), mesh.triangles()};
    const TriangleTree tree(shapes::list_of(made.points), made.triangles);
    const ClosestTriangle closest(view(made.points), made.triangles);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        const Vector3 x = made.points.row(v).transpose() + 0.3 * Vector3(random.dense(1, 3).transpose());
        const double distance = (tree.closest_place(x).point - x).norm();
        const int found = closest.to(x, (made.points.row(v).transpose() - x).norm() * (1 + 1e-9));
        ASSERT_GE(found, 0) << v;
        EXPECT_NEAR(std::sqrt(made.squared(x, found)), distance, 1e-13) << v;
        EXPECT_EQ(closest.to(x, anywhere), found) << v;
    }
}

TEST(ClosestTriangle, the_distance_is_that_to_corners_edges_and_inside)
{
    const Vector3 a(0, 0, 0), b(4, 0, 0), c(0, 3, 0);
    const Points corners = shapes::points_of({a, b, c});
    for (const std::vector<Triangle>& flat : {std::vector<Triangle>{}, {{1, 1, 2}}})
        EXPECT_EQ(ClosestTriangle(view(corners), flat).to(Vector3(0, 0, 1), anywhere), -1);
    const auto to = [&](double x, double y, double z) { return squared_distance({x, y, z}, a, b, c); };
    EXPECT_DOUBLE_EQ(to(1, 1, 2), 4);
    EXPECT_DOUBLE_EQ(to(-1, -2, 2), 9);
    EXPECT_DOUBLE_EQ(to(6, -1, 0), 5);
    EXPECT_DOUBLE_EQ(to(-1, 5, 1), 6);
    EXPECT_DOUBLE_EQ(to(2, -3, 4), 25);
    EXPECT_DOUBLE_EQ(to(-2, 1, 1), 5);
    EXPECT_DOUBLE_EQ(to(2 + 3, 1.5 + 4, 0), 25); // off the middle of the long side
}

} // namespace sinew::test_closest_triangle
