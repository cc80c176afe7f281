// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/thin_shell_nonlinear.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_thin_shell_nonlinear {

namespace {

using Options = ThinShellNonlinearOptions;
using Measure = Options::Measure;

using calls::bend;

class ThinShellNonlinear : public SurfaceFixture<sinew::ThinShellNonlinear, ThinShellNonlinearOptions>
{
public:
    static SurfaceTraits traits()
    {
        const Options thick{.measure = Measure::length, .thickness = {2.0}},
            stiff{.measure = Measure::stiffness, .stretching = {2.0}, .bending = {0.5}};
        SurfaceTraits made = nonlinear("ThinShellNonlinear",
                                       {{"default", maker(), 1, false},
                                        {"a thick sheet", maker(thick), 1, false},
                                        {"a sheet without thickness", maker({.thickness = {0.0}}), 1, false},
                                        {"stiffnesses", maker(stiff), 1, false}});
        made.follow = 3.0; // a wall of the bar that buckles snaps, also with a thousand iterations
        made.slack = 0.1;
        made.similar = 0.1; // rounding cuts the squares of the bar along one diagonal or the other
        made.apart = 0.1;
        made.iterative = true;
        made.other = maker({.thickness = {0.05}});
        return made;
    }
};

} // namespace

INSTANTIATE_TEST_SUITE_P(ThinShellNonlinear, SurfaceContract, testing::Values(ThinShellNonlinear::traits()));

TEST_F(ThinShellNonlinear, unrelated_starts_meet)
{
    const SurfaceMesh bar = shapes::bar(20, 5);
    calls::expect_starts_meet(bound(bar, {}, shapes::ends(bar, 1)), 1, 2000, 1e-8);
}

TEST_F(ThinShellNonlinear, a_folded_hinge_costs_what_its_angle_says)
{
    // Two right triangles, |e|^2 / A = 1. The cell folds as a sheet of k_b does for small angles.
    const SurfaceMesh mesh =
        shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, -1, 0}}, {{0, 1, 2}, {1, 0, 3}});
    const auto energy = [&](double bending, double angle) {
        const Method shell = bound(mesh, {.measure = Measure::stiffness, .bending = {bending}}, {{{0}, {}}});
        Points q = mesh.points();
        q.row(3) << 0.5, -std::cos(angle), std::sin(angle);
        return shell.energy(view(q));
    };
    for (const double angle : {0.01, 0.1})
        EXPECT_NEAR(energy(4.0, angle), 0.5 * 4.0 * angle * angle, 0.3 * std::pow(angle, 4) * 4.0);
    // At .7 the vector's length, 2 sin(theta / 2), is 2 % below the angle, and the triangles give a little.
    EXPECT_NEAR(energy(4.0, 0.7), 0.5 * 4.0 * 0.49, 0.04 * 0.98);
    // Below its own stiffness it does not become softer: 1 / 4, as A = |e| = 1 and both triangles are its
    // own.
    EXPECT_EQ(energy(0.1, 0.1), energy(0.0, 0.1));
    EXPECT_NEAR(energy(0.0, 0.01), 0.5 * 0.25 * 1e-4, 1e-8);
}

TEST_F(ThinShellNonlinear, rolling_and_re_rolling_a_sheet_cost_what_curvature_says)
{
    const int n = 24;
    const SurfaceMesh flat = shapes::grid(n, n, 2.0 / n);
    Points one = flat.points(), other = one;
    for (int v = 0; v < one.rows(); ++v) {
        const double a = flat.point(v).x() - 1, b = flat.point(v).y() - 1;
        one.row(v) << a, std::sin(b), std::cos(b);
        other.row(v) << std::sin(a), b, std::cos(a);
    }
    const Options options{.measure = Measure::stiffness, .stretching = {1e-3}, .bending = {1.0}};
    // 1/2 k_b k^2 over 4 units of area, of which half a row of faces at each border bends nothing.
    const double rolled = 2.0 * (n - 1) / n;
    EXPECT_NEAR(bound(flat, options, {{{0}, {}}}).energy(view(one)), rolled, 0.01 * rolled);
    // From one cylinder to the other across: the mean curvature is the same, and II is not.
    const Method roll = bound(shapes::moved(flat, one), options, {{{0}, {}}});
    EXPECT_NEAR(roll.energy(view(other)), 2 * rolled, 0.01 * 2 * rolled);
    EXPECT_LT(roll.energy(view(one)), 1e-20);
}

TEST_F(ThinShellNonlinear, painted_stiffness_decides_where_a_sheet_bends)
{
    const SurfaceMesh mesh = shapes::grid(33, 5, 0.25);
    const std::vector<Handle> handles = shapes::ends(mesh, 0.5);
    const Poses poses{shapes::still(), shapes::turn({0, 1, 0}, -60, {8, 0, 0}, {-1, 0, 3})};
    // The slope in the middle of the half that is thinner or not.
    const auto at = [&](double left) {
        Options options{.measure = Measure::length,
                        .thickness = std::vector<double>(mesh.vertex_count(), 0.5)};
        for (const int v : shapes::where(mesh, [](const Vector3& p) { return p.x() < 4; }))
            options.thickness[v] = left;
        const Solution s = solve(bound(mesh, options, handles), poses, {.max_iterations = 300});
        EXPECT_TRUE(s.positions.allFinite());
        // How much the left half turns: from its first edge to its last one.
        Vector3 first = Vector3::Zero(), last = first;
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            const double x = mesh.point(v).x();
            const Vector3 at = s.positions.row(v).transpose();
            first += (x == 0.5 ? 1.0 : x == 0.25 ? -1.0 : 0.0) * at;
            last += (x == 4.0 ? 1.0 : x == 3.75 ? -1.0 : 0.0) * at;
        }
        return std::acos(first.normalized().dot(last.normalized()));
    };
    EXPECT_GT(at(0.1), at(0.5) + 0.05);
    EXPECT_LT(at(2.0), at(0.5) - 0.05);
    EXPECT_TRUE(std::isfinite(at(0.0)));
}

TEST_F(ThinShellNonlinear, triangles_at_one_edge_of_several_all_hold_together)
{
    // Three wings at an edge, a lone triangle that touches them at a corner, and a face without area.
    const SurfaceMesh mesh = shapes::mesh({{0, 0, 0},
                                           {0, 0, 1},
                                           {1, 0, 0.5},
                                           {-0.5, 0.8, 0.5},
                                           {-0.5, -0.8, 0.5},
                                           {2, 0, 0},
                                           {2, 0, 1},
                                           {0, 0, 0.5}},
                                          {{0, 1, 2}, {0, 1, 3}, {1, 0, 4}, {2, 5, 6}, {0, 7, 1}});
    const Method shell = bound(mesh, {}, {{{2}, {}}, {{3}, {}}, {{4}, {}}});
    const Pose pose = shapes::turn({1, 1, 0}, 120, {}, {1, 2, 3});
    const Solution s = solve(shell, {pose, pose, pose}, {.max_iterations = 500, .tolerance = 1e-16});
    // Three points fix a rotation, which the start takes from the poses.
    EXPECT_LT(shapes::distance(s.positions, shapes::transformed(mesh.points(), pose)), 1e-6);
}

} // namespace sinew::test_thin_shell_nonlinear
