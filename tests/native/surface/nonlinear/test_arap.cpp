// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/nonlinear/arap.h"

#include "native/core/errors.h"
#include "tests/native/shapes.h"
#include "tests/native/surface/nonlinear/arap_oracle.h"

#include <gtest/gtest.h>

#include <limits>
#include <thread>

namespace sinew {

namespace {

using Cells = ArapOptions::Cells;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Solution
{
    Points positions;
    SolveReport report;
};

Solution solve(const Arap& arap, const Poses& poses, SolveRequest request = {})
{
    Solution solution;
    request.poses = poses;
    solution.report = arap.solve(request, solution.positions);
    return solution;
}

Arap bound(const SurfaceMesh& mesh, const ArapOptions& options, const std::vector<Handle>& handles)
{
    Arap arap(mesh, options);
    arap.set_handles(handles);
    return arap;
}

std::vector<ArapOptions> variants()
{
    std::vector<ArapOptions> all;
    for (double smoothness : {0.0, 5e-4, 0.1})
        for (Cells cells : {Cells::spokes, Cells::rims})
            all.push_back({.smoothness = smoothness, .cells = cells});
    return all;
}

std::string name_of(const ArapOptions& options)
{
    return std::string(options.cells == Cells::rims ? "rims" : "spokes") + ", smoothness " +
           std::to_string(options.smoothness);
}

/// The end at `along` goes to the end of a circular arc.
Poses bend(double degrees, double along = 12, double depth = 2)
{
    const double angle = degrees * shapes::pi / 180, radius = (along - 2 * depth) / angle;
    const Vector3 end(depth + radius * std::sin(angle), radius * (1 - std::cos(angle)), 0);
    const Vector3 from(along - depth, 0, 0);
    return {shapes::still(), shapes::turn({0, 0, 1}, degrees, from, end - from)};
}

std::vector<double> painted(int n, int seed)
{
    shapes::Random random(seed);
    std::vector<double> values(n);
    for (double& value : values)
        value = std::pow(10.0, random.signed_unit());
    return values;
}

} // namespace

TEST(Arap, rest_in_rest_out)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    for (const ArapOptions& options : variants()) {
        const Solution still = solve(bound(mesh, options, shapes::ends(mesh, 2)), Poses(2, shapes::still()));
        // One linear solve of condition 1e3 for positions of size 12.
        EXPECT_LT(shapes::distance(still.positions, mesh.points()), 1e-12) << name_of(options);
        EXPECT_LT(still.report.energy, 1e-20);
        EXPECT_TRUE(still.report.converged);
    }
}

TEST(Arap, reproduces_the_known_octahedron)
{
    // -z held, +z lifted to 1.5: the equator keeps its radius and rises to the middle, nothing
    // turns, and eight edges are 1/4 too long or short on both ends: 16 / 16 / sqrt 3.
    Arap arap(shapes::octahedron(), {.smoothness = 0, .max_iterations = 500, .tolerance = 1e-15});
    arap.set_handles({{{5}, {}}, {{4}, {}}});
    const Solution lifted = solve(arap, {shapes::still(), shapes::shift(0, 0, 0.5)});
    EXPECT_NEAR(lifted.report.energy, 0.5773502692, 1e-10);
    for (int v = 0; v < 4; ++v) {
        // E is flat at its minimum: half the digits of E in the positions.
        EXPECT_NEAR(lifted.positions(v, 2), 0.25, 1e-7);
        EXPECT_NEAR(lifted.positions.row(v).head<2>().norm(), 1.0, 1e-7);
    }
}

TEST(Arap, reproduces_rigid_motion)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    for (const ArapOptions& options : variants())
        for (double angle : {5.0, 90.0, 170.0, 180.0, 270.0})
            for (double weight : {1.0, 0.3}) {
                std::vector<Handle> handles = shapes::ends(mesh, 2);
                handles[1].weights.assign(handles[1].vertices.size(), weight);
                const Pose pose = shapes::turn({1, 2, -0.5}, angle, {3, 7, 1}, {30, -20, 10});
                const Points expected = shapes::transformed(mesh.points(), pose);
                const Arap arap = bound(mesh, options, handles);
                // Exact after the start, without an iteration: rounding of a solve at size 40.
                for (int budget : {0, 10}) {
                    const Solution moved = solve(arap, {pose, pose}, {.max_iterations = budget});
                    EXPECT_LT(shapes::distance(moved.positions, expected), 1e-11 * shapes::size(expected))
                        << name_of(options) << ", " << angle << " degrees, weight " << weight;
                }
            }
}

TEST(Arap, reproduces_rigid_motion_of_a_larger_mesh)
{
    // Large enough for a hierarchy of two levels and more.
    const SurfaceMesh mesh = shapes::bar(40, 8);
    for (double smoothness : {0.0, 5e-4}) {
        const Arap arap = bound(mesh, {.smoothness = smoothness}, shapes::ends(mesh, 2));
        const Pose pose = shapes::turn({1, 2, -0.5}, 170, {3, 7, 1}, {30, -20, 10});
        const Points expected = shapes::transformed(mesh.points(), pose);
        EXPECT_LT(shapes::distance(solve(arap, {pose, pose}, {.max_iterations = 0}).positions, expected),
                  1e-9);
    }
}

TEST(Arap, energy_never_rises_along_the_iterations)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    const std::vector<Poses> targets{
        bend(120),
        {shapes::still(), shapes::turn({1, 0, 0}, 135)},
        {shapes::still(), shapes::shift(-6, 8, 0)},
        {shapes::still(), shapes::turn({1, 0.5, 1}, 120, {11, 0, 0}, {-4, 5, 3})}};
    for (const ArapOptions& options : variants())
        for (int paint : {0, 1}) {
            ArapOptions chosen = options;
            if (paint)
                chosen.rigidity = painted(mesh.vertex_count(), 5);
            const Arap arap = bound(mesh, chosen, shapes::ends(mesh, 2));
            for (const Poses& poses : targets) {
                double before = std::numeric_limits<double>::infinity();
                for (int k = 0; k <= 16; ++k) {
                    const Solution s = solve(arap, poses, {.max_iterations = k, .tolerance = 0.0});
                    EXPECT_LE(s.report.iterations, k);
                    EXPECT_LE(s.report.energy, before * (1 + 1e-12))
                        << name_of(options) << ", iteration " << k;
                    before = s.report.energy;
                }
            }
        }
}

TEST(Arap, reports_the_energy_of_the_shape_it_returns)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    for (const ArapOptions& options : variants()) {
        const Arap arap = bound(mesh, options, shapes::ends(mesh, 2));
        for (int budget : {0, 3, 40, 400}) {
            const Solution s = solve(arap, bend(90), {.max_iterations = budget, .tolerance = 0.0});
            const double energy = arap.energy(view(s.positions));
            // energy() settles the rotations to 1e-9, a solve may end before they have.
            EXPECT_LE(energy, s.report.energy * (1 + 1e-7)) << name_of(options);
            const double lag = options.smoothness == 0 ? 1e-12 : budget == 400 ? 1e-6 : 0.2;
            EXPECT_NEAR(energy, s.report.energy, lag * energy) << name_of(options) << ", budget " << budget;
        }
    }
}

TEST(Arap, energy_is_that_of_the_definition)
{
    // Acute triangles and a few obtuse ones, whose weights are raised.
    for (const SurfaceMesh& mesh : {shapes::sphere(1), shapes::hill(4, 4), shapes::bar(4, 2)})
        for (ArapOptions options : variants()) {
            options.rigidity = painted(mesh.vertex_count(), 3);
            const Arap arap = bound(mesh, options, {{{0}, {}}});
            shapes::Random random(6);
            Points q = mesh.points();
            for (int i = 0; i < q.rows(); ++i)
                q.row(i) += 0.3 * random.vector().transpose();
            const double expected = ArapOracle(mesh, options).energy(q);
            // The settling stops at 1e-9; slower modes are left to either side.
            const double tolerance = options.smoothness == 0 ? 1e-12 : 1e-5;
            EXPECT_NEAR(arap.energy(view(q)), expected, tolerance * expected) << name_of(options);
        }
}

TEST(Arap, ends_where_the_energy_of_the_definition_is_stationary)
{
    const SurfaceMesh mesh = shapes::sphere(2);
    const std::vector<Handle> handles{
        {shapes::where(mesh, [](const Vector3& p) { return p.z() < -0.8; }), {}},
        {shapes::where(mesh, [](const Vector3& p) { return p.z() > 0.8; }), {}}};
    const Poses poses{shapes::still(), shapes::turn({1, 0, 0}, 30, {0, 0, 1}, {0.2, 0.4, 0.3})};
    for (const ArapOptions& options :
         {ArapOptions{.smoothness = 0}, ArapOptions{.smoothness = 0, .cells = Cells::rims},
          ArapOptions{.smoothness = 5e-3}}) {
        const Arap arap = bound(mesh, options, handles);
        const Solution s = solve(arap, poses, {.max_iterations = 2000, .tolerance = 1e-14});
        const ArapOracle oracle(mesh, options);
        const Solution rough = solve(arap, poses, {.max_iterations = 0});
        double at_start = 0.0, at_end = 0.0;
        for (int v = 0; v < mesh.vertex_count(); v += 7) {
            if (std::abs(mesh.point(v).z()) > 0.8)
                continue;
            at_start += oracle.slope_at(rough.positions, v, 1e-5);
            at_end += oracle.slope_at(s.positions, v, 1e-5);
        }
        // Differences of E = 0.1 over steps of 1e-5: rounding of 1e-11 each, settled to 1e-13.
        EXPECT_LT(at_end, 2e-4 * at_start) << name_of(options);
    }
}

TEST(Arap, ends_below_a_long_alternation_of_fits_and_solves)
{
    // A start far away, the textbook's flip-flop from there: not below our minimum.
    const SurfaceMesh mesh = shapes::bar(12, 3);
    const Arap arap = bound(mesh, {}, shapes::ends(mesh, 2));
    const Solution ours = solve(arap, bend(90), {.max_iterations = 200, .tolerance = 1e-10});
    const Points rest = mesh.points();
    const Solution from_rest =
        solve(arap, bend(90), {.start = view(rest), .max_iterations = 400, .tolerance = 1e-10});
    EXPECT_LE(ours.report.energy, from_rest.report.energy * (1 + 1e-6));
}

TEST(Arap, is_near_its_minimum_after_ten_iterations)
{
    const SurfaceMesh mesh = shapes::bar(20, 5);
    const Arap arap = bound(mesh, {}, shapes::ends(mesh, 1));
    for (const Poses& poses : {bend(90, 20, 1), Poses{shapes::still(), shapes::turn({1, 0, 0}, 135)},
                               Poses{shapes::still(), shapes::shift(-8, 11, 0)},
                               Poses{shapes::still(), shapes::shift(0, 10, 0)}}) {
        const double least = solve(arap, poses, {.max_iterations = 400, .tolerance = 0.0}).report.energy;
        // What the method promises: 1 % in 10, 0.1 % in 40.
        EXPECT_LT(solve(arap, poses, {.max_iterations = 10, .tolerance = 0.0}).report.energy, 1.01 * least);
        EXPECT_LT(solve(arap, poses, {.max_iterations = 40, .tolerance = 0.0}).report.energy, 1.001 * least);
        const Solution plain = solve(arap, poses);
        EXPECT_TRUE(plain.report.converged);
        EXPECT_LT(plain.report.energy, 1.001 * least);
    }
}

TEST(Arap, the_same_poses_give_the_same_bits_whatever_came_before)
{
    const SurfaceMesh mesh = shapes::bar(20, 5);
    for (double smoothness : {0.0, 5e-4}) {
        const Arap arap = bound(mesh, {.smoothness = smoothness}, shapes::ends(mesh, 2));
        const Points first = solve(arap, bend(60, 20)).positions;
        solve(arap, bend(150, 20));
        EXPECT_EQ(solve(arap, bend(60, 20)).positions, first);
        EXPECT_EQ(
            solve(bound(mesh, {.smoothness = smoothness}, shapes::ends(mesh, 2)), bend(60, 20)).positions,
            first);
    }
}

TEST(Arap, what_a_solve_leaves_to_the_next_one_changes_no_bit)
{
    const SurfaceMesh mesh = shapes::bar(24, 6);
    const auto handles = shapes::ends(mesh, 2);
    const Points incoming =
        shapes::transformed(mesh.points(), shapes::turn({1, 0, 2}, 20, {0, 0, 0}, {1, 2, 3}));
    for (const ArapOptions& options : variants()) {
        const Arap used = bound(mesh, options, handles);
        const Solution first = solve(used, bend(100, 24));
        const std::vector<SolveRequest> requests{
            {}, {.incoming = view(incoming)}, {.start = view(first.positions)}, {.max_iterations = 0}};
        for (const SolveRequest& request : requests) {
            const Solution after = solve(used, bend(-60, 24), request);
            const Solution fresh = solve(bound(mesh, options, handles), bend(-60, 24), request);
            EXPECT_EQ(after.positions, fresh.positions) << name_of(options);
            EXPECT_EQ(after.report.energy, fresh.report.energy) << name_of(options);
        }
    }
}

TEST(Arap, solves_from_several_threads_give_the_same_bits)
{
    const SurfaceMesh mesh = shapes::bar(20, 5);
    const Arap arap = bound(mesh, {}, shapes::ends(mesh, 2));
    const Points alone = solve(arap, bend(80, 20)).positions;
    std::vector<int> wrong(3, 0);
    std::vector<std::thread> threads;
    for (int& count : wrong)
        threads.emplace_back([&] {
            for (int k = 0; k < 5; ++k)
                count += solve(arap, bend(80, 20)).positions != alone;
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(wrong, std::vector<int>(3, 0));
}

TEST(Arap, ten_solves_take_one_bind)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    for (double smoothness : {0.0, 5e-4}) {
        const int each = smoothness > 0 ? 2 : 1; // positions, and the rotation field
        Arap arap(mesh, {.smoothness = smoothness});
        EXPECT_EQ(arap.set_handles(shapes::ends(mesh, 2)).factorizations, each);
        for (int k = 0; k < 10; ++k)
            solve(arap, bend(5 + k), {.max_iterations = 2});
        EXPECT_EQ(arap.set_handles(shapes::ends(mesh, 2)).factorizations, 2 * each);
    }
}

TEST(Arap, a_dragged_handle_moves_the_surface_without_jumps_and_back_again)
{
    const SurfaceMesh mesh = shapes::bar(16, 4);
    const Arap arap = bound(mesh, {}, shapes::ends(mesh, 2));
    const int steps = 30;
    const auto at = [&](int k) {
        const double t = 0.5 - 0.5 * std::cos(2 * shapes::pi * k / steps);
        return Poses{shapes::still(),
                     shapes::turn({0.2, 1, 0.5}, 100 * t, {14, 0, 0},
                                  {-4 * t, 3 * t, 2 * std::sin(2 * shapes::pi * k / steps)})};
    };
    const std::vector<int> held = shapes::ends(mesh, 2)[1].vertices;
    const Points first = solve(arap, at(0)).positions;
    Points before = first;
    for (int k = 1; k <= steps; ++k) {
        const Points now = solve(arap, at(k % steps)).positions;
        double handle_step = 0.0;
        for (int v : held)
            handle_step = std::max(handle_step, (now.row(v) - before.row(v)).norm());
        // The surface between two handles follows the faster one; a buckle would jump by its size.
        EXPECT_LT(shapes::distance(now, before), 1.5 * handle_step + 0.02) << "step " << k;
        before = now;
    }
    EXPECT_EQ(before, first); // the same poses, the same bits
}

TEST(Arap, a_warm_drag_stays_near_the_answer_from_the_poses_alone)
{
    const SurfaceMesh mesh = shapes::bar(16, 4);
    const Arap arap = bound(mesh, {}, shapes::ends(mesh, 2));
    Points shape = mesh.points();
    for (int k = 1; k <= 20; ++k)
        shape = solve(arap, bend(4.5 * k, 16), {.start = view(shape), .max_iterations = 4}).positions;
    const Points cold = solve(arap, bend(90, 16)).positions;
    EXPECT_LT(shapes::distance(shape, cold),
              0.02 * shapes::size(mesh.points())); // the study: .01 rms at worst
}

TEST(Arap, a_start_at_the_answer_stays_there)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    const Arap arap = bound(mesh, {.tolerance = 1e-10}, shapes::ends(mesh, 2));
    const Solution answer = solve(arap, bend(60), {.max_iterations = 300});
    const Solution again = solve(arap, bend(60), {.start = view(answer.positions)});
    EXPECT_LT(shapes::distance(again.positions, answer.positions),
              1e-3 * 12); // E settles to 1e-10: half its digits
    EXPECT_LE(again.report.energy, answer.report.energy * (1 + 1e-6));
}

TEST(Arap, does_not_mind_the_size_of_the_mesh)
{
    const SurfaceMesh unit = shapes::bar(12, 3);
    const Points expected = solve(bound(unit, {}, shapes::ends(unit, 2)), bend(60)).positions;
    for (double scale : {1e-12, 1e-6, 1e6, 1e12}) {
        const SurfaceMesh mesh = shapes::moved(unit, scale * unit.points());
        Poses poses = bend(60);
        for (Pose& pose : poses)
            pose.col(3) *= scale;
        const Solution s = solve(bound(mesh, {}, shapes::ends(unit, 2)), poses);
        // Rounding differs, and so may the iteration at which it stops: by a decrease below 1e-5.
        EXPECT_LT(shapes::distance(s.positions / scale, expected), 0.01) << scale;
    }
}

TEST(Arap, turns_with_the_coordinate_system)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    const Pose seen_from = shapes::turn({1, 2, 3}, 70, {0, 0, 0}, {5, -1, 2});
    const Matrix3 R = seen_from.leftCols<3>();
    Poses seen;
    for (const Pose& pose : bend(60)) {
        const Matrix3 A = R * pose.leftCols<3>() * R.transpose();
        seen.push_back(shapes::affine(A, R * pose.col(3) + seen_from.col(3) - A * seen_from.col(3)));
    }
    const SurfaceMesh elsewhere = shapes::moved(mesh, shapes::transformed(mesh.points(), seen_from));
    const Points there = solve(bound(elsewhere, {}, shapes::ends(mesh, 2)), seen).positions;
    const Points here = solve(bound(mesh, {}, shapes::ends(mesh, 2)), bend(60)).positions;
    EXPECT_LT(shapes::distance(there, shapes::transformed(here, seen_from)), 0.01); // as above
}

TEST(Arap, a_scaled_rigidity_scales_the_energy_alone)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    const Solution one =
        solve(bound(mesh, {}, shapes::ends(mesh, 2)), bend(60), {.max_iterations = 5, .tolerance = 0.0});
    // A power of two: steps taken in single precision round alike.
    const Solution more = solve(bound(mesh, {.rigidity = {16.0}}, shapes::ends(mesh, 2)), bend(60),
                                {.max_iterations = 5, .tolerance = 0.0});
    EXPECT_NEAR(more.report.energy, 16 * one.report.energy,
                1e-9 * more.report.energy); // five steps of rounding
    EXPECT_LT(shapes::distance(more.positions, one.positions), 1e-9);
}

TEST(Arap, painted_rigidity_keeps_its_region_stiffer)
{
    const SurfaceMesh mesh = shapes::bar(16, 4);
    // Length of the middle third's lines along x: stretch between the ends has to go elsewhere.
    const auto middle_length = [&](double rigidity) {
        ArapOptions options;
        options.rigidity.assign(mesh.vertex_count(), 1.0);
        for (int v : shapes::where(mesh, [](const Vector3& p) { return p.x() >= 6 && p.x() <= 10; }))
            options.rigidity[v] = rigidity;
        const Points q = solve(bound(mesh, options, shapes::ends(mesh, 2)),
                               {shapes::still(), shapes::shift(4, 0, 0)}, {.max_iterations = 100})
                             .positions;
        double low = 0.0, high = 0.0;
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            low += mesh.point(v).x() == 6 ? q(v, 0) / 16 : 0.0;
            high += mesh.point(v).x() == 10 ? q(v, 0) / 16 : 0.0;
        }
        return high - low;
    };
    const double soft = middle_length(0.1), even = middle_length(1), stiff = middle_length(100);
    EXPECT_GT(soft, even + 0.1);
    EXPECT_LT(stiff, even - 0.1);
    EXPECT_NEAR(stiff, 4.0, 0.2); // nearly as long as at rest
}

TEST(Arap, reaches_its_minimum_under_sharp_contrasts_of_rigidity)
{
    const SurfaceMesh mesh = shapes::sphere(2);
    const std::vector<Handle> handles{
        {shapes::where(mesh, [](const Vector3& p) { return p.z() < -0.8; }), {}},
        {shapes::where(mesh, [](const Vector3& p) { return p.z() > 0.8; }), {}}};
    const Poses poses{shapes::still(), shapes::turn({1, 0, 0}, 30, {0, 0, 1}, {0.2, 0.4, 0.3})};
    for (Cells cells : {Cells::spokes, Cells::rims}) {
        ArapOptions options{.smoothness = 0, .cells = cells};
        for (int v = 0; v < mesh.vertex_count(); ++v)
            options.rigidity.push_back(v % 3 ? 1.0 : 300.0);
        options.rigidity.erase(options.rigidity.begin()); // the default
        const Arap arap = bound(mesh, options, handles);
        const Solution s = solve(arap, poses, {.max_iterations = 3000, .tolerance = 1e-14});
        const Solution rough = solve(arap, poses, {.max_iterations = 0});
        const ArapOracle oracle(mesh, options);
        double at_start = 0.0, at_end = 0.0;
        for (int v = 0; v < mesh.vertex_count(); v += 7) {
            if (std::abs(mesh.point(v).z()) > 0.8)
                continue;
            at_start += oracle.slope_at(rough.positions, v, 1e-5);
            at_end += oracle.slope_at(s.positions, v, 1e-5);
        }
        // A contrast of 300 leaves two digits fewer than without.
        EXPECT_LT(at_end, 1e-2 * at_start) << name_of(options);
    }
}

TEST(Arap, a_mirrored_handle_leaves_rotations_and_energy_sound)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    const Poses mirrored{shapes::still(), shapes::affine(Vector3(1, 1, -1).asDiagonal())};
    for (const ArapOptions& options : variants()) {
        const Arap arap = bound(mesh, options, shapes::ends(mesh, 2));
        const Solution s = solve(arap, mirrored);
        ASSERT_TRUE(s.positions.allFinite());
        // A mirrored cell fits no rotation: the energy cannot be that of a rigid motion.
        EXPECT_GT(s.report.energy, 1.0);
        if (options.smoothness > 0)
            continue; // mirrored cells have several settled fields of rotations
        const double expected = ArapOracle(mesh, options).energy(s.positions);
        EXPECT_NEAR(arap.energy(view(s.positions)), expected, 1e-12 * expected) << name_of(options);
    }
}

TEST(Arap, refuses_options_that_mean_nothing)
{
    const SurfaceMesh mesh = shapes::cube();
    for (double bad : {-1.0, nan, std::numeric_limits<double>::infinity()}) {
        EXPECT_THROW(Arap(mesh, {.smoothness = bad}), InvalidOption);
        EXPECT_THROW(Arap(mesh, {.tolerance = bad}), InvalidOption);
        EXPECT_THROW(Arap(mesh, {.rigidity = {bad}}), InvalidOption);
    }
    EXPECT_THROW(Arap(mesh, {.rigidity = {0.0}}), InvalidOption);
    EXPECT_THROW(Arap(mesh, {.rigidity = std::vector<double>(8, 0.0)}), InvalidOption);
    EXPECT_THROW(Arap(mesh, {.rigidity = {}}), InvalidOption);
    EXPECT_THROW(Arap(mesh, {.rigidity = {1, 1}}), InvalidOption);
    EXPECT_THROW(Arap(mesh, {.max_iterations = 0}), InvalidOption);
    try {
        std::vector<double> paint(8, 1.0);
        paint[2] = -1;
        Arap(mesh, {.rigidity = paint});
        FAIL();
    } catch (const InvalidOption& error) {
        EXPECT_EQ(error.elements(), std::vector{2});
        EXPECT_EQ(error.element_kind(), Error::Element::vertex);
    }
}

TEST(Arap, refuses_what_does_not_fit_a_solve)
{
    const SurfaceMesh mesh = shapes::bar(4, 2);
    const Arap arap = bound(mesh, {}, shapes::ends(mesh, 1));
    const Poses poses = bend(20, 4, 1);
    Points broken = mesh.points();
    broken(3, 0) = nan;
    const Points other = Points::Zero(4, 3);
    const std::vector<bool> flags{true};
    EXPECT_THROW(solve(arap, {shapes::still()}), InvalidConstraint);
    EXPECT_THROW(solve(arap, poses, {.incoming = view(other)}), InvalidConstraint);
    EXPECT_THROW(solve(arap, poses, {.incoming = view(broken)}), InvalidConstraint);
    EXPECT_THROW(solve(arap, poses, {.from_rest = flags}), InvalidConstraint);
    EXPECT_THROW(solve(arap, poses, {.start = view(other)}), InvalidConstraint);
    EXPECT_THROW(solve(arap, poses, {.start = view(broken)}), InvalidConstraint);
    EXPECT_THROW(solve(arap, poses, {.max_iterations = -1}), InvalidOption);
    EXPECT_THROW(solve(arap, poses, {.tolerance = -1.0}), InvalidOption);
    EXPECT_THROW(solve(arap, poses, {.tolerance = nan}), InvalidOption);
    EXPECT_THROW(arap.energy(view(other)), InvalidConstraint);
    EXPECT_THROW(arap.energy(view(broken)), InvalidConstraint);
    Poses infinite = poses;
    infinite[0](2, 2) = std::numeric_limits<double>::infinity();
    EXPECT_THROW(solve(arap, infinite), InvalidConstraint);
}

} // namespace sinew
