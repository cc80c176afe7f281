// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/points/wires.h"

#include "tests/native/methods/space/contract.h"
#include "tests/native/refusals.h"

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

TEST(Wires, a_straight_wire_has_the_closed_form)
{
    // Moved along y by 1, without a turn: x' = x + f(d / r) e_y with f(t) = (1 - t^2)^2.
    const Points rest = line(41, {-5, 0, 0}, {5, 0, 0}), points = scattered(300);
    Points posed = rest;
    posed.col(1).array() += 1.0;
    const Points out = warped({.radius = {1.25}}, rest, posed, points);
    for (int i = 0; i < points.rows(); ++i) {
        const double t = std::hypot(points(i, 1), points(i, 2)) / 1.25;
        const double falloff = t < 1 ? (1 - t * t) * (1 - t * t) : 0.0;
        EXPECT_LT((out.row(i) - points.row(i) - falloff * Eigen::RowVector3d::UnitY()).norm(), 1e-14);
    }
}

TEST(Wires, scale_and_turn_are_those_of_the_paper)
{
    // A wire along x that is turned by 90 degrees to y about its middle. At the middle nothing moves, so x is
    // scaled by 1 + (s - 1) F and turned by F times 90 degrees.
    const Points rest = line(21, {-1, 0, 0}, {1, 0, 0});
    const Points posed = shapes::transformed(rest, shapes::turn({0, 0, 1}, 90));
    const double falloff = (1 - 0.25) * (1 - 0.25);
    const Vector3 turned = shapes::rotation({0, 0, 1}, 90 * falloff) * Vector3(0, 0.5, 0);
    const Points out = warped({.scale = {2.0}, .smoothing = 0.0}, rest, posed, one(0, 0.5, 0));
    EXPECT_LT((out.row(0).transpose() - (1 + falloff) * turned).norm(), 1e-14);
    const Points still = warped({.rotation = {0.0}, .smoothing = 0.0}, rest, posed, one(0, 0.5, 0));
    EXPECT_LT((still - one(0, 0.5, 0)).norm(), 1e-15) << "without rotation only places count";
}

TEST(Wires, the_parameter_counts_and_not_the_length)
{
    // The second half of the wire is stretched. The sample in the middle stays the middle of the parameter.
    const Points rest = line(3, {0, 0, 0}, {2, 0, 0});
    Points posed = rest;
    posed.row(2) << 11, 0, 0;
    const Points out = warped({}, rest, posed, stacked(one(1, 0, 0), one(1.5, 0, 0)));
    EXPECT_LT(shapes::distance(out, stacked(one(1, 0, 0), one(6, 0, 0))), 1e-14);
}

TEST(Wires, coincident_wires_do_not_add_up)
{
    const Points rest = arc(9), points = scattered(200);
    Points posed = rest;
    posed.col(2).array() += 0.7;
    posed.row(3) << 1, 1, 1;
    const Points alone = warped({}, rest, posed, points);
    for (const double m : {0.0, 1.0, 2.5}) {
        const Points twice =
            warped({.counts = {9, 9}, .exponent = m}, stacked(rest, rest), stacked(posed, posed), points);
        EXPECT_LT(shapes::distance(twice, alone), 1e-14) << m;
    }
}

TEST(Wires, several_wires_blend_by_the_power_of_their_moves)
{
    // Two long wires on both sides of the point, which both have it in the middle of their radius.
    const Points rest = stacked(line(2, {-9, -.5, 0}, {9, -.5, 0}), line(2, {-9, .5, 0}, {9, .5, 0}));
    Points posed = rest;
    posed.topRows(2).col(2).array() += 1.0;
    posed.bottomRows(2).col(2).array() += 3.0;
    const double f = 0.5625, a = f, b = 3 * f;
    for (const double m : {0.0, 1.0, 2.0, 5.5}) {
        const Points out = warped({.counts = {2, 2}, .exponent = m}, rest, posed, one(0, 0, 0));
        const double expected = (a * std::pow(a, m) + b * std::pow(b, m)) / (std::pow(a, m) + std::pow(b, m));
        EXPECT_NEAR(out(0, 2), expected, 1e-14) << m;
    }
    posed.bottomRows(2) = rest.bottomRows(2);
    EXPECT_NEAR(warped({.counts = {2, 2}}, rest, posed, one(0, 0, 0))(0, 2), a, 1e-15)
        << "a wire that stays does not hold the point back";
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

TEST(Wires, refuses_what_is_no_wire)
{
    Points rest = stacked(line(3, {0, 0, 0}, {1, 0, 0}), stacked(line(2, {5, 5, 5}, {5, 5, 5}), arc(3)));
    const auto made = [&](const WireOptions& options) { return Wires(rest, options); };
    expect_elements(refusal<InvalidConstraint>([&] { made({.counts = {3, 2, 3}}); }), Error::Element::handle,
                    {1});
    EXPECT_THROW(made({.counts = {3, 2}}), InvalidOption);
    EXPECT_THROW(made({.counts = {7, 1}}), InvalidOption);
    EXPECT_THROW(made({.radius = {0.0}}), InvalidOption);
    EXPECT_THROW(made({.radius = {1.0, 2.0}}), InvalidOption);
    EXPECT_THROW(made({.rotation = {1.5}}), InvalidOption);
    EXPECT_THROW(made({.scale = {std::numeric_limits<double>::quiet_NaN()}}), InvalidOption);
    EXPECT_THROW(made({.domain = rest.topRows(4)}), InvalidOption);
    EXPECT_THROW(made({.exponent = -1.0}), InvalidOption);
    EXPECT_THROW(made({.smoothing = -0.1}), InvalidOption);
    EXPECT_THROW(Wires(Points(0, 3)), Error);
    EXPECT_THROW(Wires(rest.topRows(1)), Error);
    rest(4, 1) = std::numeric_limits<double>::infinity();
    expect_elements(refusal<InvalidConstraint>([&] { made({}); }), Error::Element::vertex, {4});
    const MemoryLimit limit(1000);
    Wires wires(arc(9));
    const Points many = scattered(1000, 0.5);
    EXPECT_THROW(wires.bind(view(many)), OutOfMemory);
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
