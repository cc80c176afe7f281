// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/sketch/silhouette_lines.h"

#include "native/methods/surface/sketch/occlusion.h"
#include "native/methods/surface/sketch/silhouette_sketch.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

// Other lines and strokes, and what is made of them, are in tests/bindings/surfaces/test_silhouette_sketch.py.
namespace sinew::test_silhouette_lines {

TEST(SilhouetteLines, along_chosen_edges_end_where_three_meet)
{
    const SurfaceMesh sheet = shapes::quad_grid(4, 4); // rows of five vertices
    const std::vector<std::array<int, 2>> edges = {{5, 6}, {7, 6}, {7, 8}, {7, 12}, {5, 6}, {20, 20}};
    const std::vector<SurfaceLine> lines = edge_lines(sheet, edges, {});
    std::vector<std::size_t> sizes;
    for (const SurfaceLine& line : lines) {
        EXPECT_FALSE(line.closed);
        sizes.push_back(line.points.size());
    }
    std::ranges::sort(sizes);
    EXPECT_EQ(sizes, (std::vector<std::size_t>{2, 2, 3}));
    const std::vector<std::array<int, 2>> beyond = {{0, 25}};
    expect_elements(refusal<InvalidConstraint>([&] { edge_lines(sheet, beyond, {}); }),
                    Error::Element::vertex, {25});
}

TEST(SilhouetteSketch, ten_strokes_take_one_factorisation)
{
    const std::vector<LinePoint> line{{3, 3, 0.0}, {11, 11, 0.0}, {19, 19, 0.0}};
    const SilhouetteSketch sketch(shapes::hill(7, 8), line, {0, 7});
    Points positions;
    for (int k = 0; k < 10; ++k) {
        const Points targets = Points::Constant(3, 3, k);
        sketch.solve(view(targets), positions);
    }
    EXPECT_EQ(sketch.factorizations(), 1);
}

TEST(Occlusion, hides_no_point_of_the_outline_of_a_ball_and_every_point_behind_another)
{
    const SurfaceMesh ball = shapes::sphere(3);
    for (const bool near : {false, true}) {
        SketchView view{shapes::Random(11).rotation(), {}};
        const Vector3 toward = view.axes.row(2).transpose();
        if (near)
            view.eye = 6 * toward;
        const Occlusion alone(ball, view);
        for (const SurfaceLine& line : silhouette_lines(ball, view))
            for (const LinePoint& point : line.points)
                EXPECT_FALSE(alone.hides(point));
        // A second ball stands before the first one, and is smaller on the screen where it is not nearer.
        const Vector3 before = 3 * toward + 0.8 * view.axes.row(0).transpose();
        const SurfaceMesh both = shapes::joined(ball, ball, before);
        const Occlusion occlusion(both, view);
        int hidden = 0;
        for (const SurfaceLine& line : silhouette_lines(both, view))
            for (const LinePoint& point : line.points) {
                const bool is_behind = point.a < ball.vertex_count();
                const Vector3 x = point.on(sinew::view(both.points()));
                // The oracle: the distance of the second centre from the line of sight.
                const Vector3 way = view.toward(x).normalized(), arm = before - x;
                const double off = (arm - arm.dot(way) * way).norm();
                if (is_behind && off < 0.97) {
                    EXPECT_TRUE(occlusion.hides(point)) << off;
                    ++hidden;
                } else if (!is_behind || off > 1.0) {
                    EXPECT_FALSE(occlusion.hides(point)) << off;
                }
            }
        EXPECT_GT(hidden, 5);
    }
}

} // namespace sinew::test_silhouette_lines
