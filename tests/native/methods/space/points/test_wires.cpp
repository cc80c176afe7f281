// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/points/wires.h"

#include "tests/native/methods/space/contract.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sinew::test_wires {

namespace {

/// Samples of a quarter of the unit circle in the plane z = 0, from +x to +y.
Points arc(int samples, const Vector3& centre = Vector3::Zero())
{
    Points points(samples, 3);
    for (int k = 0; k < samples; ++k) {
        const double angle = 0.5 * shapes::pi * k / (samples - 1);
        points.row(k) = (centre + Vector3(std::cos(angle), std::sin(angle), 0.0)).transpose();
    }
    return points;
}

Points line(int samples, const Vector3& from, const Vector3& to)
{
    Points points(samples, 3);
    for (int k = 0; k < samples; ++k)
        points.row(k) = (from + (to - from) * k / (samples - 1)).transpose();
    return points;
}

Points stacked(const Points& a, const Points& b)
{
    Points both(a.rows() + b.rows(), 3);
    both << a, b;
    return both;
}

Points scattered(int count, double size = 1.5) { return shapes::Random(3).points(count, size); }

Points warped(const WireOptions& options, const Points& rest, const Points& control, const Points& points)
{
    Wires wires(rest, options);
    wires.bind(view(points));
    Points out(points.rows(), 3);
    wires.warp(view(control), {}, out.data());
    return out;
}

Points one(double x, double y, double z) { return Eigen::RowVector3d(x, y, z); }

SpaceTraits traits()
{
    const Points rest = stacked(arc(12), line(9, {-1, -0.5, 0.5}, {1, -0.5, 0.5}));
    WireOptions wide{.counts = {12, 9}, .radius = {0.8, 0.6}}, plain = wide, limited = wide;
    plain.smoothing = 0.0;
    plain.exponent = 3.0;
    plain.rotation = {0.5};
    limited.domain = rest;
    limited.domain.topRows(12).setConstant(std::numeric_limits<double>::quiet_NaN());
    limited.domain.bottomRows(9).col(2).array() += 0.3;
    const auto variant = [rest](const char* name, const WireOptions& options) {
        return SpaceVariant{name, [=] { return std::make_shared<Wires>(rest, options); }};
    };
    return {.name = "Wires",
            .variants = {variant("smooth", wide), variant("paper", plain), variant("domain", limited)},
            .control = rest,
            .points = scattered(600),
            .translation = {}, // of what is in reach alone
            .follow = 12.0, // the last segment is an eighth of the wire, and turns space within its radius
            .other = [=] { return std::make_shared<Wires>(rest, WireOptions{.counts = {12, 9}}); }};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(Wires, SpaceContract, testing::Values(traits()));

TEST(Wires, points_on_a_wire_follow_it_and_those_outside_stay)
{
    const Points rest = arc(9), points = stacked(rest, stacked(one(1.51, 0, 0), one(-1, -1, 0)));
    const Points posed = shapes::Random(1).shaken(rest, 1.0);
    for (const double smoothing : {0.0, 0.2, 1.0}) {
        const Points out =
            warped({.radius = {0.5}, .scale = {3.0}, .smoothing = smoothing}, rest, posed, points);
        EXPECT_LT(shapes::distance(out.topRows(9), posed), 1e-14) << smoothing;
        EXPECT_EQ(out.bottomRows(2), points.bottomRows(2)) << "outside the radius";
    }
}

TEST(Wires, is_continuous_where_the_nearest_point_jumps)
{
    // A V, whose two legs are equally near on the plane x = 0. The left one moves down, the right one up.
    Points rest(3, 3), posed(3, 3);
    rest << -1, 1, 0, 0, 0, 0, 1, 1, 0;
    posed << -1, 1, -1, 0, 0, 0, 1, 1, 1;
    const auto jump = [&](double step, double smoothing) {
        const Points sides = stacked(one(-step, 0.8, 0), one(step, 0.8, 0));
        const Points out = warped({.rotation = {0.0}, .smoothing = smoothing}, rest, posed, sides);
        return (out.row(1) - out.row(0)).norm();
    };
    EXPECT_GT(jump(1e-7, 0.0), 0.3) << "the rule of the paper tears";
    double last = jump(1e-2, 0.2);
    for (double step = 1e-3; step > 1e-8; step *= 0.1) {
        const double next = jump(step, 0.2);
        EXPECT_LT(next, 0.11 * last) << "the difference falls with the step: " << step;
        last = next;
    }
}

TEST(Wires, a_walk_past_every_curve_has_no_jump)
{
    // Random wires, walked past along random lines: halving the step halves the longest difference.
    shapes::Random random(8);
    Points rest(24, 3), posed(24, 3);
    for (int v = 0; v < 24; ++v) {
        rest.row(v) = random.vector().transpose();
        posed.row(v) = rest.row(v) + 0.3 * random.vector().transpose();
    }
    const auto longest = [&](int steps) {
        const Points walk = line(steps + 1, {-1, -0.7, 0.2}, {1, 0.8, -0.1});
        const Points out = warped({.counts = {12, 12}, .radius = {0.7}}, rest, posed, walk);
        return (out.bottomRows(steps) - out.topRows(steps)).rowwise().norm().maxCoeff();
    };
    const double coarse = longest(200000), fine = longest(400000);
    EXPECT_LT(fine, 0.6 * coarse);
}

TEST(Wires, a_domain_curve_limits_the_wire_on_its_side)
{
    const Points rest = line(21, {-5, 0, 0}, {5, 0, 0});
    Points posed = rest, domain = rest;
    posed.col(2).array() += 1.0;
    domain.col(1).array() += 0.5;
    const Points points = stacked(stacked(one(0, 0.5, 0), one(0, 0.7, 0)),
                                  stacked(stacked(one(0, 0.25, 0), one(0, -0.5, 0)), one(0, 0, -0.5)));
    const Points out = warped({.domain = domain, .smoothing = 0.0}, rest, posed, points);
    const double half = 0.5625; // f(1/2)
    const double expected[] = {0.0, 0.0, half, half, half};
    for (int i = 0; i < 5; ++i)
        EXPECT_NEAR(out(i, 2) - points(i, 2), expected[i], 1e-14) << i;
}

TEST(Wires, a_closed_wire_has_a_last_segment)
{
    Points rest(3, 3), posed;
    rest << 0, 0, 0, 4, 0, 0, 0, 4, 0;
    posed = rest;
    posed.col(2).array() += 1.0;
    const Points point = one(0, 2, 0);
    EXPECT_EQ(warped({}, rest, posed, point), point);
    EXPECT_NEAR(warped({.closed = {true}}, rest, posed, point)(0, 2), 1.0, 1e-15);
}

TEST(Wires, a_point_moves_the_same_alone_and_among_many)
{
    const Points rest = stacked(arc(40), line(9, {-1, -0.5, 0.5}, {1, -0.5, 0.5})), many = scattered(70000);
    Points posed = rest;
    posed.col(2) += 0.3 * rest.col(0);
    const WireOptions options{.counts = {40, 9}, .closed = {true, false}, .radius = {0.8, 0.6}};
    // Points are bound in slabs, and contacts packed by fours: the packs end elsewhere in each of these.
    for (const int fewer : {0, 1, 2, 3}) {
        const Points some = many.bottomRows(many.rows() - fewer);
        const Points together = warped(options, rest, posed, some);
        for (const int i : {0, 1, 2, 3, 65533, 65534, 65535, 65536, 65537, 65538, 69990})
            EXPECT_EQ(warped(options, rest, posed, some.row(i)), together.row(i)) << fewer << " " << i;
    }
}

TEST(Wires, doubled_samples_and_turned_wires_stay_finite)
{
    Points rest(5, 3), posed(5, 3);
    rest << 0, 0, 0, 1, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0;
    posed << 3, 0, 0, 2, 0, 0, 2, 0, 0, 1, 0, 0, 0, 0, 0; // turned round
    const Points out = warped({.radius = {2.0}}, rest, posed, scattered(200, 2.0));
    EXPECT_TRUE(out.allFinite());
    posed.setZero(); // contracted to a point
    EXPECT_TRUE(warped({.radius = {2.0}}, rest, posed, scattered(200, 2.0)).allFinite());
}

TEST(Wires, says_what_it_costs)
{
    Wires wires(line(2, {-9, 0, 0}, {9, 0, 0}));
    Points points = scattered(1000, 0.5);
    points.bottomRows(500).col(2).array() += 10.0;
    // In reach: 44 bytes and two samples of 12; each point: 4 bytes; and one more of each list.
    EXPECT_EQ(wires.bind(view(points)).weight_bytes, 500 * (46 + 2 * 8) + 1001 * 4 + 8);
}

} // namespace sinew::test_wires
