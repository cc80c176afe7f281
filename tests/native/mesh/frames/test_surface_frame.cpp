// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/frames/surface_frame.h"

#include "tests/native/shapes.h"

namespace sinew::test_surface_frame {

/// The vertex is far away.
SurfaceMesh hill_with_a_loose_vertex()
{
    return shapes::joined(shapes::hill(9, 5), shapes::mesh({{300, 20, -50}}, {}), {0, 0, 0});
}

TEST(SurfaceFrame, has_the_size_of_simple_shapes)
{
    EXPECT_NEAR(surface_frame(shapes::sphere(5)).size, 4.0, 0.005);              // all of it at distance 1
    EXPECT_NEAR(surface_frame(shapes::quad_grid(3, 3)).size, 12 / std::sqrt(6), 1e-12); // side^2 / 6
    EXPECT_NEAR(surface_frame(shapes::cube()).size, 4 * std::sqrt(5.0 / 12), 1e-12); // 1 / 4 + 1 / 6
    const SurfaceMesh line = shapes::mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}});
    EXPECT_GT(surface_frame(line).size, 1.0);
    EXPECT_EQ(surface_frame(shapes::mesh({{5, 5, 5}}, {})).size, 1.0);
}

TEST(SurfaceFrame, goes_with_the_surface_alone)
{
    const SurfaceMesh hill = shapes::hill(9, 5), loose = hill_with_a_loose_vertex();
    const SurfaceFrame frame = surface_frame(hill);
    EXPECT_EQ(surface_frame(loose).size, frame.size);
    const Pose pose = shapes::turn({1, 2, 3}, 77, {4, 5, 6}, {100, -30, 7});
    const SurfaceFrame there = surface_frame(shapes::moved(hill, shapes::transformed(hill.points(), pose)));
    EXPECT_NEAR(there.size, frame.size, 1e-12);
    EXPECT_LT((there.axes - pose.leftCols<3>() * frame.axes).norm(), 1e-9);
    EXPECT_LT((there.centre - apply(pose, frame.centre)).norm(), 1e-12);
    EXPECT_NEAR(frame.axes.determinant(), 1.0, 1e-12);
    EXPECT_LT((frame.out(frame.in(hill.point(3))) - hill.point(3)).norm(), 1e-12);
}

TEST(SurfaceFrame, goes_with_symmetric_surfaces_that_are_turned_or_mirrored)
{
    for (const SurfaceMesh& mesh :
         {shapes::cube(), shapes::quad_grid(4, 4), shapes::quad_grid(6, 2), shapes::sphere(2)}) {
        const SurfaceFrame frame = surface_frame(mesh);
        const std::vector<int> order = order_by_place(view(mesh.points()), frame);
        Pose pose = shapes::turn({1, 2, 3}, 157, {4, 5, 6}, {100, -30, 7});
        for (const bool mirrored : {false, true}) {
            if (mirrored)
                pose.col(0) *= -1;
            const Points points = shapes::transformed(mesh.points(), pose);
            const SurfaceMesh turned = shapes::moved(mesh, points); // as Apply Scale does
            const SurfaceFrame there = surface_frame(mirrored ? shapes::inside_out(turned) : turned);
            EXPECT_EQ(order_by_place(view(points), there), order);
            EXPECT_NEAR(there.axes.determinant(), 1.0, 1e-12);
            for (int k = 0; k < 3; ++k) // but for the side of one of them
                EXPECT_NEAR(std::abs(there.axes.col(k).dot(pose.leftCols<3>() * frame.axes.col(k))), 1.0,
                            1e-9);
        }
    }
}

TEST(SurfaceFrame, parts_have_sizes_of_their_own)
{
    const SurfaceMesh hill = hill_with_a_loose_vertex();
    const SurfaceMesh both = shapes::joined(hill, shapes::cube(), {500, 0, 0});
    const std::vector<double> sizes = part_sizes(both), alone = part_sizes(shapes::cube());
    for (int v = 0; v < hill.vertex_count(); ++v) // the loose one has that of the largest part
        EXPECT_NEAR(sizes[v], surface_frame(hill).size, 1e-12);
    EXPECT_NEAR(sizes.back(), alone.front(), 1e-12);
}

TEST(SurfaceFrame, orders_points_by_where_they_are)
{
    const SurfaceMesh hill = shapes::hill(9, 5);
    const int n = hill.vertex_count();
    const SurfaceFrame frame = surface_frame(hill);
    const std::vector<int> order = order_by_place(view(hill.points()), frame);
    const Pose pose = shapes::turn({1, 2, 3}, 77, {4, 5, 6}, {100, -30, 7});
    Points reversed = shapes::transformed(hill.points(), pose).colwise().reverse();
    SurfaceFrame there = frame;
    there.centre = apply(pose, frame.centre);
    there.axes = pose.leftCols<3>() * frame.axes;
    const std::vector<int> again = order_by_place(view(reversed), there);
    for (int k = 0; k < n; ++k)
        EXPECT_EQ(again[k], n - 1 - order[k]);
    EXPECT_TRUE(std::ranges::is_permutation(order, shapes::numbers(0, n)));
}

} // namespace sinew::test_surface_frame
