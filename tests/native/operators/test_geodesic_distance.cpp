// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/geodesic_distance.h"

#include "native/mesh/edge_distances.h"
#include "tests/native/shapes.h"

namespace sinew::test_geodesic_distance {

TEST(GeodesicDistance, from_a_straight_line_is_exact)
{
    const SurfaceMesh plane = shapes::grid(12, 9, 0.5, 0.2);
    std::vector<GeodesicDistance::Source> line;
    for (int v : shapes::where(plane, [](const Vector3& p) { return p.x() == 0.0; }))
        line.push_back({v});
    const std::vector<double> found = GeodesicDistance(plane).from(line);
    for (int v = 0; v < plane.vertex_count(); ++v)
        EXPECT_NEAR(found[v], plane.point(v).x(), 1e-13);
}

TEST(GeodesicDistance, on_a_sphere_nears_the_angle_as_edges_get_shorter)
{
    double before = 0.12 / 0.75; // at first edges of about 0.2
    for (int level : {3, 4, 5}) {
        const SurfaceMesh ball = shapes::sphere(level);
        const std::vector<double> found = GeodesicDistance(ball).from({{4}}); // +z
        double error = 0.0;
        for (int v = 0; v < ball.vertex_count(); ++v)
            error = std::max(error, std::abs(found[v] - std::acos(std::clamp(ball.point(v).z(), -1.0, 1.0))));
        EXPECT_LT(error, 0.75 * before); // as h log 1/h: .71 and less
        before = error;
    }
}

TEST(GeodesicDistance, lies_between_the_straight_way_and_the_way_along_edges)
{
    const SurfaceMesh plane = shapes::grid(15, 15, 1.0, 0.45); // with obtuse angles
    const std::vector<Vector3> points = shapes::list_of(plane.points());
    const std::vector<double> found = GeodesicDistance(plane).from({{37}});
    const std::vector<double> edges = EdgeDistances(points, plane.triangles()).from(37);
    for (int v = 0; v < plane.vertex_count(); ++v) {
        const double straight = (points[v] - points[37]).norm();
        EXPECT_GE(found[v], straight * (1 - 1e-12)); // distances are convex along an edge
        EXPECT_LE(found[v], edges[v] * (1 + 1e-12));
        EXPECT_LE(found[v], 1.12 * straight + 0.4);
    }
}

// Among slivers distances shorten in ever smaller steps: thousands for each vertex, if all were taken.
TEST(GeodesicDistance, of_a_mesh_pressed_flat_takes_no_longer_than_its_size_asks)
{
    const SurfaceMesh plane = shapes::grid(80, 80, 1.0, 0.45);
    for (double height : {0.01, 0.0}) {
        const SurfaceMesh pressed = shapes::moved(plane, plane.points() * Vector3(1, height, 1).asDiagonal());
        const std::vector<double> edges =
            EdgeDistances(shapes::list_of(pressed.points()), pressed.triangles()).from(85);
        std::int64_t shortenings = 0;
        const std::vector<double> found = GeodesicDistance(pressed).from({{85}}, &shortenings);
        EXPECT_LT(shortenings, 60 * pressed.vertex_count())
            << "36 per vertex; 30,000 if all steps were taken";
        for (int v = 0; v < plane.vertex_count(); ++v) {
            const double straight = (pressed.point(v) - pressed.point(85)).norm();
            EXPECT_GE(found[v], straight * (1 - 1e-12));
            EXPECT_LE(found[v], 1.005 * edges[v]);
        }
    }
}

TEST(GeodesicDistance, does_not_depend_on_the_size_of_the_mesh)
{
    const SurfaceMesh hill = shapes::hill(8, 7);
    const std::vector<double> expected = GeodesicDistance(hill).from({{3}, {50, 0.7}});
    for (double scale : {1e-40, 1e30}) {
        const SurfaceMesh scaled = shapes::moved(hill, scale * hill.points());
        const std::vector<double> found = GeodesicDistance(scaled).from({{3}, {50, 0.7 * scale}});
        for (int v = 0; v < hill.vertex_count(); ++v)
            EXPECT_NEAR(found[v], scale * expected[v], 1e-11 * scale);
    }
}

TEST(GeodesicDistance, starts_where_the_sources_say_and_does_not_leave_a_part)
{
    const SurfaceMesh both = shapes::joined(shapes::grid(4, 1), shapes::messy(), {50, 0, 0});
    const std::vector<double> found = GeodesicDistance(both).from({{0, 1.0}, {1, 100.0}});
    EXPECT_EQ(found[0], 1.0);
    EXPECT_NEAR(found[1], 2.0, 1e-14) << "nearer to the other source";
    EXPECT_NEAR(found[4], 5.0, 1e-13);
    for (int v = 10; v < both.vertex_count(); ++v)
        EXPECT_TRUE(std::isinf(found[v]));
    const std::vector<double> messy = GeodesicDistance(both).from({{10}});
    for (int v = 10; v < both.vertex_count() - 4; ++v)
        EXPECT_TRUE(std::isfinite(messy[v])) << v;
}

} // namespace sinew::test_geodesic_distance
