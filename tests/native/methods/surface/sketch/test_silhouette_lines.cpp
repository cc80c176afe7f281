// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/sketch/silhouette_lines.h"

#include "native/methods/surface/sketch/occlusion.h"

#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_silhouette_lines {

namespace {

SketchView turned(int seed)
{
    shapes::Random random(seed);
    return {random.rotation(), {}};
}

Points places(const SurfaceMesh& mesh, const std::vector<LinePoint>& line)
{
    Points found(static_cast<Eigen::Index>(line.size()), 3);
    for (std::size_t k = 0; k < line.size(); ++k)
        found.row(static_cast<Eigen::Index>(k)) = line[k].on(view(mesh.points())).transpose();
    return found;
}

/// The farthest that the silhouette of a unit sphere is from the circle that it should be.
double off_the_circle(int level, const SketchView& view)
{
    const SurfaceMesh ball = shapes::sphere(level);
    const std::vector<SurfaceLine> lines = silhouette_lines(ball, view);
    EXPECT_EQ(lines.size(), 1U);
    EXPECT_TRUE(lines[0].closed);
    const Points on = places(ball, lines[0].points);
    // All points whose line of sight touches the sphere: p . e = 1 from the eye e, p . v = 0 from afar.
    double worst = 0.0;
    for (int k = 0; k < on.rows(); ++k) {
        const Vector3 p = on.row(k).transpose();
        const double height =
            view.eye ? (p.dot(*view.eye) - 1) / view.eye->norm() : p.dot(view.axes.row(2).transpose());
        worst = std::max({worst, std::abs(height), std::abs(p.norm() - 1)});
    }
    return worst;
}

/// The part of a silhouette that begins at its first point, as a stroke at another depth.
Points stroke_along(const SketchView& view, const Points& on, int count, bool backwards)
{
    Points stroke(count, 3);
    for (int k = 0; k < count; ++k) {
        const Vector3 p = on.row((backwards ? count - 1 - k : k) % on.rows()).transpose();
        stroke.row(k) = (view.eye ? Vector3(*view.eye + 0.3 * (p - *view.eye))
                                  : Vector3(p + 7 * view.axes.row(2).transpose()))
                            .transpose();
    }
    return stroke;
}

} // namespace

TEST(SilhouetteLines, of_a_sphere_is_the_circle_that_is_seen_from_afar_or_by_a_near_eye)
{
    for (const bool near : {false, true})
        for (int seed : {1, 2, 3}) {
            SketchView view = turned(seed);
            if (near)
                view.eye = 2.5 * view.axes.row(2).transpose() + 0.3 * view.axes.row(0).transpose();
            double before = off_the_circle(2, view);
            for (int level : {3, 4, 5}) {
                const double now = off_the_circle(level, view);
                EXPECT_LT(now,
                          before / 2.5); // linear interpolation: a quarter, which irregular edges disturb
                before = now;
            }
            EXPECT_LT(before, 2e-3); // edges of length 0.05: a chord is 3e-4 below the sphere
        }
}

TEST(SilhouetteLines, leave_out_what_is_behind_the_viewer)
{
    const SurfaceMesh sheet = shapes::quad_grid(5, 4);
    SketchView view;
    view.axes << 1, 0, 0, 0, 0, 1, 0, -1, 0; // looking along y, from the middle of the sheet
    view.eye = Vector3(2.5, 1.5, 1);
    for (const SurfaceLine& line : silhouette_lines(sheet, view))
        for (const LinePoint& point : line.points)
            EXPECT_GT(view.depth(point.on(sinew::view(sheet.points()))), 0);
}

TEST(SilhouetteLines, of_a_messy_mesh_are_finite)
{
    const SurfaceMesh mesh = shapes::messy();
    for (int seed : {1, 2, 3, 4})
        for (const SurfaceLine& line : silhouette_lines(mesh, turned(seed))) {
            EXPECT_GE(line.points.size(), 2U);
            EXPECT_TRUE(places(mesh, line.points).allFinite());
        }
}

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

TEST(FitStroke, that_runs_along_the_silhouette_moves_nothing)
{
    const SurfaceMesh ball = shapes::sphere(3);
    for (const bool near : {false, true}) {
        SketchView view = turned(4);
        if (near)
            view.eye = 3 * view.axes.row(2).transpose();
        const std::vector<SurfaceLine> lines = silhouette_lines(ball, view);
        const Points on = places(ball, lines[0].points);
        const int whole = static_cast<int>(on.rows());
        for (const bool backwards : {false, true})
            for (const int count : {9, whole / 2, whole - 1, whole + 1}) { // the last one is closed
                const Points stroke = stroke_along(view, on, count, backwards);
                const auto fit = fit_stroke(ball, lines, view, sinew::view(stroke));
                ASSERT_TRUE(fit);
                EXPECT_GE(static_cast<int>(fit->points.size()), std::min(count, whole));
                EXPECT_LT(shapes::distance(places(ball, fit->points), fit->targets), 1e-12); // rounding
            }
    }
}

TEST(FitStroke, puts_the_nearer_side_of_the_outline_onto_the_stroke_and_keeps_its_depth)
{
    const SurfaceMesh ball = shapes::sphere(4);
    SketchView view = turned(6);
    view.eye = 4 * view.axes.row(2).transpose();
    const std::vector<SurfaceLine> lines = silhouette_lines(ball, view);
    Points stroke(21, 3);
    for (int k = 0; k < 21; ++k) { // from the top over the right to the bottom, with a bump
        const double angle = shapes::pi * (0.5 - k / 20.0), size = 1 + 0.3 * std::cos(angle);
        stroke.row(k) = size * std::cos(angle) * view.axes.row(0) + size * std::sin(angle) * view.axes.row(1);
    }
    const auto fit = fit_stroke(ball, lines, view, sinew::view(stroke));
    ASSERT_TRUE(fit);
    const Points on = places(ball, fit->points);
    for (int k = 0; k < on.rows(); ++k) {
        const Vector3 p = on.row(k).transpose(), t = fit->targets.row(k).transpose();
        EXPECT_NEAR(view.depth(p), view.depth(t), 1e-12);
        EXPECT_GT(view.seen(p)[0], -0.02); // an end goes to the nearest place, which is near the top
        double nearest = 1.0;
        for (int s = 0; s + 1 < 21; ++s) {
            const Eigen::Vector2d a = view.seen(stroke.row(s).transpose()),
                                  b = view.seen(stroke.row(s + 1).transpose()), at = view.seen(t);
            const double share = std::clamp((at - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
            nearest = std::min(nearest, (at - a - share * (b - a)).norm());
        }
        EXPECT_LT(nearest, 1e-12);
    }
    EXPECT_GT(fit->points.size(), lines[0].points.size() / 3);
}

TEST(Occlusion, hides_no_point_of_the_outline_of_a_ball_and_every_point_behind_another)
{
    const SurfaceMesh ball = shapes::sphere(3);
    for (const bool near : {false, true}) {
        SketchView view = turned(11);
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

TEST(FitStroke, leaves_out_lines_that_are_hidden)
{
    const SurfaceMesh ball = shapes::sphere(3);
    const SketchView view;
    const SurfaceMesh both =
        shapes::joined(shapes::over(1.3 * ball.points(), shapes::faces_of(ball)), ball, {0, 0, -4});
    Points stroke(21, 3); // along the outline of the one behind
    for (int k = 0; k < 21; ++k) {
        const double angle = 0.05 * shapes::pi * (k - 10);
        stroke.row(k) << std::cos(angle), std::sin(angle), 0;
    }
    const std::vector<SurfaceLine> lines = silhouette_lines(both, view);
    const auto any = fit_stroke(both, lines, view, sinew::view(stroke));
    ASSERT_TRUE(any);
    EXPECT_GE(any->points.front().a, ball.vertex_count()) << "the nearest one";
    const Occlusion occlusion(both, view);
    const auto seen = fit_stroke(both, lines, view, sinew::view(stroke), 0.5,
                                 [&](const LinePoint& point) { return occlusion.hides(point); });
    ASSERT_TRUE(seen);
    EXPECT_LT(seen->points.front().a, ball.vertex_count());
    EXPECT_FALSE(fit_stroke(both, lines, view, sinew::view(stroke), 0.5,
                            [](const LinePoint& /*point*/) { return true; }));
}

TEST(FitStroke, far_from_every_line_finds_none)
{
    const SurfaceMesh ball = shapes::sphere(2);
    const SketchView view;
    Points stroke(2, 3);
    stroke << 3, -0.2, 0, 3, 0.2, 0;
    EXPECT_FALSE(fit_stroke(ball, silhouette_lines(ball, view), view, sinew::view(stroke)));
    EXPECT_TRUE(fit_stroke(ball, silhouette_lines(ball, view), view, sinew::view(stroke), 10));
    EXPECT_FALSE(fit_stroke(ball, {}, view, sinew::view(stroke)));
}

} // namespace sinew::test_silhouette_lines
