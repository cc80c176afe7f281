// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/vector_field.h"

#include "tests/native/methods/space/contract.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_vector_field {

namespace {

/// A frame of a tool as its four points.
Points frame(const Pose& pose = shapes::still())
{
    Points axes(4, 3);
    axes << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
    return shapes::transformed(axes, pose);
}

Points path(const std::vector<Pose>& poses)
{
    Points frames(4 * static_cast<Eigen::Index>(poses.size()), 3);
    for (std::size_t k = 0; k < poses.size(); ++k)
        frames.middleRows<4>(4 * static_cast<Eigen::Index>(k)) = frame(poses[k]);
    return frames;
}

Points at_rest(std::size_t frames) { return path(std::vector<Pose>(frames, shapes::still())); }

Points scattered(int count, double size = 1.6) { return shapes::Random(4).points(count, size); }

VectorFieldOptions tool(FieldTool kind, double inner = 0.4, double outer = 1.2)
{
    // A bend of wide things on a short way would squeeze what lies on its inner side: that is for other
    // tests.
    if (kind == FieldTool::bend)
        return {.tools = {kind}, .inner = {0.2}, .outer = {2.2}, .width = {0.7}};
    return {.tools = {kind}, .inner = {inner}, .outer = {outer}, .width = {1.5}};
}

Points warped(const VectorFieldOptions& options, const std::vector<Pose>& poses, const Points& points)
{
    VectorField field(at_rest(poses.size()), options);
    field.bind(view(points));
    const Points control = path(poses);
    Points out(points.rows(), 3);
    field.warp(view(control), {}, out.data());
    return out;
}

/// A move and a turn without symmetry, small enough to leave points in every region.
Pose some_pose() { return shapes::affine(shapes::rotation({1, 2, -1}, 70), {0.5, -0.3, 0.6}); }

constexpr FieldTool every_tool[] = {FieldTool::drag, FieldTool::twist, FieldTool::bend};

/// The determinant of the derivative of the warp at a point, by central differences.
double stretch(const VectorFieldOptions& options, const std::vector<Pose>& poses, const Points& at)
{
    constexpr double step = 1e-4;
    Points around(6 * at.rows(), 3);
    for (Eigen::Index i = 0; i < at.rows(); ++i)
        for (int k = 0; k < 6; ++k) {
            around.row(6 * i + k) = at.row(i);
            around(6 * i + k, k / 2) += k % 2 ? -step : step;
        }
    const Points out = warped(options, poses, around);
    double worst = 0.0;
    for (Eigen::Index i = 0; i < at.rows(); ++i) {
        Matrix3 J;
        for (int k = 0; k < 3; ++k)
            J.col(k) = (out.row(6 * i + 2 * k) - out.row(6 * i + 2 * k + 1)).transpose() / (2 * step);
        worst = std::max(worst, std::abs(J.determinant() - 1.0));
    }
    return worst;
}

SpaceTraits traits()
{
    // Two tools: a drag of three frames, then a bend or a twist of one.
    Points rest(16, 3);
    rest << at_rest(3), frame(shapes::shift(0.2, 0.1, -0.3));
    const auto variant = [rest](const char* name, const VectorFieldOptions& options) {
        return SpaceVariant{name, [=] { return std::make_shared<VectorField>(rest, options); }};
    };
    const auto second = [](FieldTool kind) {
        return VectorFieldOptions{.counts = {3, 1},
                                  .tools = {FieldTool::drag, kind},
                                  .inner = {0.3, 0.1},
                                  .outer = {0.9, 1.5},
                                  .width = {0.5}};
    };
    VectorFieldOptions stepped = second(FieldTool::drag);
    stepped.order = 2;
    stepped.steps = 7;
    return {.name = "VectorField",
            .variants = {variant("bend", second(FieldTool::bend)), variant("twist", second(FieldTool::twist)),
                         variant("stepped", stepped)},
            .control = rest,
            .points = scattered(600),
            .translation = {}, // of what is in reach alone
            // The end of an axis of length 1 turns points that are up to 3 away, and what a bend squeezes on
            // its inner side moves aside faster than that.
            .follow = 12.0,
            .other = [=] { return std::make_shared<VectorField>(rest, second(FieldTool::drag)); }};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(VectorField, SpaceContract, testing::Values(traits()));

TEST(VectorField, moves_the_inner_ball_rigidly_and_nothing_outside)
{
    const Points points = scattered(3000);
    const Pose pose = some_pose();
    const Points out = warped(tool(FieldTool::drag), {pose}, points);
    const Points rigid = shapes::transformed(points, pose);
    const Vector3 way = pose.col(3);
    int inside = 0, outside = 0;
    for (int i = 0; i < points.rows(); ++i) {
        const Vector3 x = points.row(i);
        if (x.norm() < 0.4) {
            ++inside;
            EXPECT_LT((out.row(i) - rigid.row(i)).norm(), 1e-14);
        }
        const double along = std::clamp(x.dot(way) / way.squaredNorm(), 0.0, 1.0);
        if ((x - along * way).norm() > 1.2) {
            ++outside;
            EXPECT_EQ(out.row(i), points.row(i));
        }
    }
    EXPECT_GT(inside, 10);
    EXPECT_GT(outside, 10);
}

TEST(VectorField, linear_p_and_q_translate_exactly_by_any_rule)
{
    // Without the closed form for rigid points: they pass from the inner ball of the first frame on.
    const Points points = scattered(100, 0.5);
    const Pose pose = shapes::shift(0.3, 0.7, -0.2);
    for (const int order : {1, 2, 4}) {
        VectorFieldOptions options = tool(FieldTool::drag, 2.0, 3.0);
        options.order = order;
        options.steps = 3;
        EXPECT_LT(shapes::distance(warped(options, {pose}, points), shapes::transformed(points, pose)),
                  1e-14);
        const VectorField field(at_rest(1), options);
        const Points control = path({pose}), v = field.velocities(view(control), 0, 0.5, view(points));
        for (int i = 0; i < v.rows(); ++i)
            EXPECT_LT((v.row(i).transpose() - pose.col(3)).norm(), 1e-15);
    }
}

TEST(VectorField, bends_what_is_above_rigidly_and_keeps_what_is_below)
{
    const Pose pose = shapes::turn({1, 0, 0}, 60);
    const Points points = scattered(20000, 3.0);
    const Points out = warped(tool(FieldTool::bend), {pose}, points);
    const Points rigid = shapes::transformed(points, pose);
    int above = 0, below = 0, beside = 0;
    for (int i = 0; i < points.rows(); ++i) {
        // On both sides of every axis halfway, which turns by up to 30 degrees.
        const Vector3 begin = Vector3::UnitZ(), end = shapes::rotation({1, 0, 0}, 30) * begin;
        const double low = std::min(points.row(i).dot(begin), rigid.row(i).dot(end));
        const double around = std::hypot(points(i, 0), points(i, 1));
        if (low > 2.25 && around < 0.65) {
            ++above;
            EXPECT_LT((out.row(i) - rigid.row(i)).norm(), 1.2e-5) << "the tolerance of the integration";
        }
        if (std::max(points.row(i).dot(begin), points.row(i).dot(end)) < 0.2) {
            ++below;
            EXPECT_EQ(out.row(i), points.row(i));
        }
        const Vector3 back = shapes::rotation({1, 0, 0}, -60) * points.row(i).transpose();
        if (std::min(around, std::hypot(back.x(), back.y())) > 1.4 && points(i, 1) > 0.0) {
            ++beside;
            EXPECT_EQ(out.row(i), points.row(i)) << "the bend is to the other side";
        }
    }
    EXPECT_GT(above, 20);
    EXPECT_GT(below, 100);
    EXPECT_GT(beside, 20);
}

TEST(VectorField, a_turn_about_another_axis_is_no_twist_and_no_bend)
{
    const Points points = scattered(100);
    EXPECT_EQ(warped(tool(FieldTool::bend), {shapes::turn({0, 0, 1}, 80)}, points), points);
    EXPECT_LT(shapes::distance(warped(tool(FieldTool::twist), {shapes::turn({1, 0, 0}, 80)}, points), points),
              1e-12);
}

TEST(VectorField, the_volume_drifts_less_with_a_higher_order)
{
    const Points points = scattered(60, 0.9);
    for (const FieldTool kind : {FieldTool::drag, FieldTool::bend}) {
        double last = 1e9;
        for (const int order : {1, 2, 4}) {
            VectorFieldOptions options = tool(kind);
            options.order = order;
            options.steps = 40;
            const double drift = stretch(options, {some_pose()}, points);
            EXPECT_LT(drift, 0.2 * last) << order;
            last = drift;
        }
        EXPECT_LT(last, 1e-4);
        VectorFieldOptions exact = tool(kind);
        exact.tolerance = 1e-9;
        EXPECT_LT(stretch(exact, {some_pose()}, points), 1e-4)
            << "the tolerance over the step of differences";
    }
}

TEST(VectorField, the_order_is_what_it_says)
{
    // Against the same rule with many more steps: halving the step divides the error by 2^order.
    const Points points = scattered(40, 0.8);
    for (const int order : {1, 2, 4}) {
        const auto end = [&](int steps) {
            VectorFieldOptions options =
                tool(FieldTool::drag, 0.0, 2.0); // no kink within reach of the points
            options.order = order;
            options.steps = steps;
            return warped(options, {shapes::affine(shapes::rotation({0, 1, 1}, 40), {0.2, 0.1, 0.3})},
                          points);
        };
        const Points exact = end(4000);
        const double coarse = shapes::distance(end(20), exact), fine = shapes::distance(end(40), exact);
        EXPECT_NEAR(std::log2(coarse / fine), order, 0.25) << order;
    }
}

TEST(VectorField, the_way_back_restores)
{
    const Points points = scattered(500);
    for (const FieldTool kind : every_tool) {
        VectorFieldOptions options = tool(kind);
        options.tolerance = 1e-9;
        const std::vector<Pose> there_and_back{some_pose(), shapes::shift(0, 0.2, 0), some_pose(),
                                               shapes::still()};
        const Points out = warped(options, there_and_back, points);
        EXPECT_LT(shapes::distance(out, points), 1e-6) << "the tolerance times the growth of errors";
    }
}

TEST(VectorField, more_steps_reach_the_tolerance)
{
    const Points points = scattered(500);
    VectorFieldOptions options = tool(FieldTool::drag), exact = options;
    exact.steps = 4000;
    const Points reference = warped(exact, {some_pose()}, points);
    double last = 1.0;
    for (const double tolerance : {1e-3, 1e-5, 1e-7}) {
        options.tolerance = tolerance;
        const double error = shapes::distance(warped(options, {some_pose()}, points), reference);
        EXPECT_LT(error, 5.0 * tolerance) << "errors grow on the rest of the way as space is drawn out";
        EXPECT_LT(error, 0.1 * last);
        last = error;
    }
}

TEST(VectorField, does_not_turn_space_over)
{
    // Far drags through the points, where plain displacements by beta would fold: tiny cells keep their
    // sides.
    const Points at = scattered(2000, 1.2);
    constexpr double side = 1e-6; // far drags draw cells out by more than a thousand
    Points cells(4 * at.rows(), 3);
    for (int i = 0; i < at.rows(); ++i)
        for (int k = 0; k < 4; ++k)
            cells.row(4 * i + k) = at.row(i) + (k ? side : 0.0) * Eigen::RowVector3d::Unit((k + 2) % 3);
    VectorFieldOptions far = tool(FieldTool::drag, 0.2, 1.0);
    far.tolerance = 1e-12;
    const Points out = warped(far, {shapes::shift(0.3, 0, 2.5), shapes::shift(1, 1, 0)}, cells);
    for (int i = 0; i < at.rows(); ++i) {
        Matrix3 edges;
        for (int k = 0; k < 3; ++k)
            edges.col(k) = (out.row(4 * i + k + 1) - out.row(4 * i)).transpose() / side;
        EXPECT_NEAR(edges.determinant(), 1.0, 0.2) << i;
    }
}

TEST(VectorField, the_path_counts_and_not_only_its_end)
{
    const Points points = scattered(200);
    const Pose end = shapes::shift(0.8, 0.8, 0);
    const auto drag = tool(FieldTool::drag);
    const Points straight = warped(drag, {end}, points);
    EXPECT_GT(shapes::distance(straight, warped(drag, {shapes::shift(0.8, 0, 0), end}, points)), 0.05);
    EXPECT_LT(shapes::distance(straight, warped(drag, {shapes::shift(0.4, 0.4, 0), end}, points)), 3e-5)
        << "a stop on the way changes nothing beyond the tolerance";
    EXPECT_EQ(warped(drag, {end, end}, points), straight) << "nor does a stop at the end";
}

TEST(VectorField, a_scaled_tool_reaches_farther)
{
    Points point(1, 3);
    point << 0, 0, 1.5;
    const Pose grown = shapes::affine(2.0 * Matrix3::Identity(), {0.5, 0, 0});
    EXPECT_EQ(warped(tool(FieldTool::drag), {shapes::shift(0.5, 0, 0)}, point), point);
    EXPECT_GT(shapes::distance(warped(tool(FieldTool::drag), {grown}, point), point), 1e-3);
    const Pose gone = shapes::affine(Matrix3::Zero(), {0.5, 0, 0});
    EXPECT_TRUE(warped(tool(FieldTool::drag), {gone}, scattered(100)).allFinite());
}

} // namespace sinew::test_vector_field
