// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/thin_shell_nonlinear.h"

#include "native/core/errors.h"
#include "tests/native/methods/surface/fixture.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <Eigen/QR>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numeric>

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

TEST_F(ThinShellNonlinear, a_rigid_motion_by_170_degrees_costs_nothing)
{
    const SurfaceMesh mesh = shapes::bar(20, 5);
    const Method shell = bound(mesh, {}, shapes::ends(mesh, 2));
    const double bent = solve(shell, bend(90, 20, 2)).report.energy;
    const Pose pose = shapes::turn({1, 2, 3}, 170, {1, 2, 3}, {5, 6, 7});
    const Solution turned = solve(shell, {pose, pose});
    EXPECT_LE(turned.report.energy, 1e-24 * bent);
    EXPECT_LT(shapes::distance(turned.positions, shapes::transformed(mesh.points(), pose)), 1e-12 * 40);
    EXPECT_LE(shell.energy(view(mesh.points())), 1e-24 * bent);
}

TEST_F(ThinShellNonlinear, unrelated_starts_meet)
{
    const SurfaceMesh bar = shapes::bar(20, 5);
    const SurfaceMesh centred = shapes::moved(bar, bar.points().rowwise() - Eigen::RowVector3d(0, 2.5, 2.5));
    calls::expect_starts_meet(bound(centred, {}, shapes::ends(centred, 1)), 1, 2000, 1e-8);
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

TEST_F(ThinShellNonlinear, a_lifted_annulus_tends_to_the_plate)
{
    // Rings of nearly equilateral triangles between the radii 1 and 2; the inner border is lifted a little,
    // both are clamped. The plate's middle rises by .45843; the hinges of this pattern come to .4550.
    const int rings = 32, around = static_cast<int>(std::lround(2 * shapes::pi * 1.5 * rings));
    const double h = 1.0 / rings, lift = 1e-3;
    std::vector<Vector3> points;
    shapes::Polygons faces;
    for (int k = -1; k <= rings + 1; ++k)
        for (int i = 0; i < around; ++i) {
            const double a = (i + 0.5 * (k & 1)) * 2 * shapes::pi / around, r = 1 + k * h;
            points.emplace_back(r * std::cos(a), r * std::sin(a), 0.0);
        }
    for (int k = 0; k < rings + 2; ++k)
        for (int i = 0; i < around; ++i) {
            const int a = k * around + i, b = k * around + (i + 1) % around, c = a + around, d = b + around;
            if (k % 2 == 0) { // the first ring and every second one are shifted by half a step
                faces.push_back({a, c, b});
                faces.push_back({b, c, d});
            } else {
                faces.push_back({a, c, d});
                faces.push_back({a, d, b});
            }
        }
    const SurfaceMesh mesh = shapes::mesh(points, faces);
    const auto radius = [](const Vector3& p) { return p.norm(); };
    const std::vector<Handle> handles{
        {shapes::where(mesh, [&](const Vector3& p) { return radius(p) < 1 + 0.3 * h; }), {}},
        {shapes::where(mesh, [&](const Vector3& p) { return radius(p) > 2 - 0.3 * h; }), {}}};
    const Method shell = bound(mesh, {.measure = Measure::length, .thickness = {1.0}}, handles);
    const Points q = solve(shell, {shapes::shift(0, 0, lift), shapes::still()},
                           {.max_iterations = 300, .tolerance = 1e-14})
                         .positions;
    std::vector<int> near =
        shapes::where(mesh, [&](const Vector3& p) { return std::abs(radius(p) - 1.5) < 0.75 * h; });
    MatrixX basis(near.size(), 2);
    VectorX height(near.size());
    for (std::size_t k = 0; k < near.size(); ++k) {
        basis.row(k) << 1.0, mesh.point(near[k]).norm() - 1.5;
        height[k] = q(near[k], 2) / lift;
    }
    EXPECT_NEAR(basis.colPivHouseholderQr().solve(height)[0], 0.4550, 1e-3);
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

TEST_F(ThinShellNonlinear, names_vertices_where_the_sheet_is_too_thin_for_the_mesh)
{
    const SurfaceMesh mesh = shapes::grid(8, 8);
    const auto thin = [&](const Options& options) {
        Method shell(mesh, options);
        return shell.set_handles({{{0}, {}}}).thin_vertices;
    };
    EXPECT_TRUE(thin({.measure = Measure::length, .thickness = {1.0}}).empty());
    EXPECT_EQ(thin({.measure = Measure::length, .thickness = {0.1}}).size(),
              77u); // the four corners lie at no inner edge
    Options painted{.measure = Measure::length, .thickness = std::vector<double>(81, 1.0)};
    for (int v = 0; v < 81; ++v)
        if (mesh.point(v).x() < 3.5)
            painted.thickness[v] = 0.0;
    for (const int v : thin(painted))
        EXPECT_LT(mesh.point(v).x(), 4.5);
    EXPECT_GE(thin(painted).size(), 27u);
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

/// Four times the root mean square of the distance of the area from its centroid, by many small triangles.
double spread_size(const SurfaceMesh& mesh)
{
    double area = 0.0, square = 0.0;
    Vector3 sum = Vector3::Zero();
    constexpr int across = 64;
    for (const auto& [a, b, c] : mesh.triangles()) {
        const Vector3 u = (mesh.point(b) - mesh.point(a)) / across,
                      v = (mesh.point(c) - mesh.point(a)) / across;
        const double own = 0.5 * u.cross(v).norm();
        for (int i = 0; i < across; ++i)
            for (int j = 0; j + i < across; ++j)
                for (int turned = 0; turned < (i + j + 1 < across ? 2 : 1); ++turned) {
                    const double share = (1.0 + turned) / 3;
                    const Vector3 p = mesh.point(a) + (i + share) * u + (j + share) * v;
                    area += own;
                    sum += own * p;
                    square += own * p.squaredNorm();
                }
    }
    return 4 * std::sqrt(square / area - (sum / area).squaredNorm());
}

TEST_F(ThinShellNonlinear, measures_are_ways_to_say_the_same)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    const double size = spread_size(mesh);
    const auto shape = [&](const Options& options) {
        return solve(bound(mesh, options, shapes::ends(mesh, 2)), bend(60, 12, 2)).positions;
    };
    const Points share = shape({.thickness = {0.05}}),
                 length = shape({.measure = Measure::length, .thickness = {0.05 * size}}),
                 pair = shape(
                     {.measure = Measure::stiffness, .stretching = {4.0}, .bending = {0.01 * size * size}});
    EXPECT_LT(shapes::distance(share, length), 1e-4); // the size is one of points in small triangles
    EXPECT_LT(shapes::distance(length, pair), 1e-9); // four times both stiffnesses
}

TEST_F(ThinShellNonlinear, a_region_painted_black_stays_solvable)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    std::vector<double> paint(mesh.vertex_count(), 1.0);
    for (int v : shapes::where(mesh, [](const Vector3& p) { return p.x() > 4 && p.x() < 8; }))
        paint[v] = 0.0;
    for (const Options& options :
         {Options{.thickness = paint}, Options{.measure = Measure::stiffness, .stretching = paint},
          Options{.measure = Measure::stiffness, .bending = paint}})
        EXPECT_TRUE(
            solve(bound(mesh, options, shapes::ends(mesh, 2)), bend(60, 12, 2)).positions.allFinite());
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

TEST_F(ThinShellNonlinear, refuses_options_and_points_that_mean_nothing)
{
    std::vector<Options> bad{{.measure = Measure::stiffness, .stretching = {0.0}},
                             {.thickness = {1.0, 1.0}},
                             {.max_iterations = 0}};
    for (double number : {-1.0, nan, infinity})
        for (const Options& options : {Options{.thickness = {number}}, Options{.tolerance = number},
                                       Options{.bending = {number}}, // though it does not count
                                       Options{.measure = Measure::stiffness, .stretching = {number}},
                                       Options{.measure = Measure::stiffness, .bending = {number}}})
            bad.push_back(options);
    expect_refused(shapes::cube(), bad);
    std::vector<double> paint(8, 1.0);
    paint[2] = -1;
    const auto make = [&] { Method(shapes::cube(), {.thickness = paint}); };
    expect_elements(refusal<InvalidOption>(make), Error::Element::vertex, {2});
    const SurfaceMesh mesh = shapes::bar(4, 2);
    expect_other_points_refused(bound(mesh, {}, shapes::ends(mesh, 1)));
}

} // namespace sinew::test_thin_shell_nonlinear
