// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/arap.h"

#include "tests/native/methods/surface/contract.h"
#include "tests/native/methods/surface/nonlinear/arap_oracle.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>

namespace sinew::test_arap {

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

auto maker(const ArapOptions& options)
{
    return [options](const SurfaceMesh& mesh) { return std::make_shared<Arap>(mesh, options); };
}

SurfaceTraits traits()
{
    std::vector<SurfaceVariant> all{{"default", maker({}), 2, false}};
    for (const ArapOptions& options : variants()) {
        const bool smooth = options.smoothness > 0; // alpha is scaled by the area of the whole mesh
        all.push_back({name_of(options), maker(options), smooth ? 2 : 1, !smooth});
    }
    all.push_back({"point handles", maker({.point_handles = 0.3}), 3, false});
    const auto drag = [](double s) {
        const double t = 0.5 - 0.5 * std::cos(2 * shapes::pi * s);
        return Poses{shapes::still(), shapes::turn({0.2, 1, 0.5}, 100 * t, {18, 0, 0},
                                                   {-4 * t, 3 * t, 2 * std::sin(2 * shapes::pi * s)})};
    };
    return {.name = "Arap",
            .variants = all,
            .mesh = shapes::bar(12, 3),
            .large = shapes::bar(20, 5), // for a hierarchy of more than one level
            .depth = 2,
            .bent = bend(60),
            .drag = drag,
            .drag_steps = 30,
            .follow = 1.5, // the surface between two handles follows the faster one;
            .slack = 0.02, // a buckle would jump by its size
            .rest = 1e-12, // one linear solve of condition 1e3 for positions of size 12
            .incoming = 1e-11, // edges are taken from what enters: nothing is strained
            .noise = 0.2,
            .translation = 1e-9,
            .rigid = 1e-11, // rounding of a solve at size 40
            .held = 2e-13,
            .alone = 1e-13,
            .similar = 0.01, // rounding differs, and so may the iteration at which it stops:
            .scaled = 0.01,  // by a decrease below 1e-5
            .apart = 0.05,
            .messy = 30.0,
            .all_soft = 1.0,
            .other = maker({.rigidity = {2.0}})};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(Arap, SurfaceContract, testing::Values(traits()));

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

TEST(Arap, energy_never_rises_along_the_iterations)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    const std::vector<Poses> targets{
        bend(120),
        {shapes::still(), shapes::turn({1, 0, 0}, 135)},
        {shapes::still(), shapes::shift(-6, 8, 0)},
        {shapes::still(), shapes::turn({1, 0.5, 1}, 120, {11, 0, 0}, {-4, 5, 3})}};
    const auto expect_falling = [&](const ArapOptions& options, const std::vector<Handle>& handles) {
        SCOPED_TRACE(name_of(options));
        const Arap arap = bound(mesh, options, handles);
        for (const Poses& poses : targets) {
            double before = std::numeric_limits<double>::infinity();
            for (int k = 0; k <= 16; ++k) {
                const SolveReport s = solve(arap, poses, {.max_iterations = k, .tolerance = 0.0}).report;
                EXPECT_LE(s.iterations, k);
                EXPECT_LE(s.energy, before * (1 + 1e-12)) << "iteration " << k;
                before = s.energy;
            }
        }
    };
    std::vector<Handle> soft = shapes::ends(mesh, 2);
    soft[1].weights.assign(soft[1].vertices.size(), 0.9);
    for (ArapOptions options : variants()) {
        expect_falling(options, shapes::ends(mesh, 2));
        expect_falling(options, soft);
        options.rigidity = painted(mesh.vertex_count(), 5);
        expect_falling(options, shapes::ends(mesh, 2));
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
    std::vector<double> sharp;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        sharp.push_back(v % 3 ? 1.0 : 300.0);
    struct Case
    {
        ArapOptions options;
        int iterations;
        double left; ///< of the slope at the start
    };
    // Differences of E = 0.1 over steps of 1e-5: rounding of 1e-11 each, settled to 1e-13.
    // A contrast of 300 leaves two digits fewer than without.
    for (const auto& [options, iterations, left] :
         {Case{{.smoothness = 0}, 2000, 2e-4}, Case{{.smoothness = 0, .cells = Cells::rims}, 2000, 2e-4},
          Case{{.smoothness = 5e-3}, 2000, 2e-4}, Case{{.smoothness = 0, .rigidity = sharp}, 3000, 1e-2},
          Case{{.smoothness = 0, .cells = Cells::rims, .rigidity = sharp}, 3000, 1e-2}}) {
        const Arap arap = bound(mesh, options, handles);
        const Solution s = solve(arap, poses, {.max_iterations = iterations, .tolerance = 1e-14});
        const Solution rough = solve(arap, poses, {.max_iterations = 0});
        const ArapOracle oracle(mesh, options);
        double at_start = 0.0, at_end = 0.0;
        for (int v = 0; v < mesh.vertex_count(); v += 7) {
            if (std::abs(mesh.point(v).z()) > 0.8)
                continue;
            at_start += oracle.slope_at(rough.positions, v, 1e-5);
            at_end += oracle.slope_at(s.positions, v, 1e-5);
        }
        EXPECT_LT(at_end, left * at_start) << name_of(options);
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

TEST(Arap, six_iterations_settle_soft_bends_and_twists)
{
    // A slab bends softly; steps in the metric alone leave .2 to .4 % of the box after six iterations.
    for (const SurfaceMesh& mesh : {shapes::bar(40, 10), shapes::bar(60, 6)}) {
        const double length = mesh.points().col(0).maxCoeff(), size = shapes::size(mesh.points());
        const Arap arap = bound(mesh, {}, shapes::ends(mesh, 3));
        for (const Poses& poses : {bend(60, length), Poses{shapes::still(), shapes::turn({1, 0, 0}, 90)}}) {
            const Points limit = solve(arap, poses, {.max_iterations = 600, .tolerance = 1e-12}).positions;
            const Points six = solve(arap, poses, {.max_iterations = 6, .tolerance = 0.0}).positions;
            EXPECT_LT(shapes::distance(six, limit), 1e-3 * size);
        }
    }
}

TEST(Arap, last_bits_of_poses_and_of_the_rest_shape_stay_small)
{
    // Symmetric meshes, whose clusters and diagonals are decided between equals; by poses that end within the
    // iterations of a frame.
    struct Case
    {
        SurfaceMesh mesh;
        double depth;
        std::vector<Poses> all;
    };
    const std::vector<Case> cases{
        {shapes::bar(24, 6),
         2,
         {bend(60, 24),
          {shapes::still(), shapes::turn({1, 0, 0}, 90)},
          {shapes::still(), shapes::turn({0.3, 1, 0.2}, 70, {22, 0, 0}, {-3, 2, 4})}}},
        {shapes::sphere(4),
         0.2,
         {{shapes::still(), shapes::turn({0, 0, 1}, 60, {0.9, 0, 0}, {0.3, 0.2, 0})},
          {shapes::still(), shapes::turn({1, 0.2, 0}, 80, {0.9, 0, 0}, {0.5, 0, 0.3})}}}};
    shapes::Random random(3);
    for (const auto& [mesh, depth, all] : cases) {
        const double size = shapes::size(mesh.points());
        const auto noise = [&](auto numbers, double share) {
            for (int i = 0; i < numbers.size(); ++i)
                numbers.data()[i] += share * random.signed_unit();
            return numbers;
        };
        const std::vector<Handle> handles = shapes::ends(mesh, depth);
        const Arap arap = bound(mesh, {}, handles);
        const Arap other = bound(shapes::moved(mesh, noise(mesh.points(), 3e-8 * size)), {}, handles);
        for (Poses poses : all) {
            const Points positions = solve(arap, poses).positions;
            EXPECT_LT(shapes::distance(solve(other, poses).positions, positions), 1e-4 * size) << "rest";
            for (Pose& pose : poses) {
                pose.col(3) = noise(Vector3(pose.col(3)), 1e-7 * size);
                pose.leftCols<3>() = noise(Matrix3(pose.leftCols<3>()), 1e-7);
            }
            EXPECT_LT(shapes::distance(solve(arap, poses).positions, positions), 1e-4 * size) << "poses";
        }
    }
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

TEST(Arap, a_single_vertex_leaves_no_spike_with_point_handles)
{
    // A plate whose rim stays; its middle vertex is lifted. How far its neighbours stay behind, as a share of
    // the mean slope from there to the rim, is how sharp the tip is: without the option the more, the finer
    // the mesh.
    const auto sharpness = [](int n, const ArapOptions& options) {
        const SurfaceMesh mesh = shapes::grid(n, n, 10.0 / n);
        const std::vector<int> rim = shapes::where(
            mesh, [](const Vector3& p) { return std::min({p.x(), p.y(), 10 - p.x(), 10 - p.y()}) < 1e-9; });
        const int middle = n / 2 * (n + 1) + n / 2;
        const Points q = solve(bound(mesh, options, {{rim, {}}, {{middle}, {}}}),
                               {shapes::still(), shapes::shift(0, 0, 1)}, {.max_iterations = 300})
                             .positions;
        EXPECT_EQ(q(middle, 2), 1.0);
        return (1.0 - q(middle + 1, 2)) * (n / 2);
    };
    for (double smoothness : {0.0, 5e-4}) {
        const double coarse = sharpness(20, {.smoothness = smoothness}),
                     fine = sharpness(40, {.smoothness = smoothness});
        EXPECT_GT(fine, coarse) << smoothness;
        for (int n : {20, 40}) {
            const double some = sharpness(n, {.smoothness = smoothness, .point_handles = 0.5}),
                         most = sharpness(n, {.smoothness = smoothness, .point_handles = 0.9});
            EXPECT_LT(some, 0.6 * (n == 20 ? coarse : fine)) << smoothness << ", " << n;
            EXPECT_LT(most, some) << smoothness << ", " << n;
        }
    }
    // The tip becomes rounder on a finer mesh. Without smoothness the start decides between several minima.
    EXPECT_LT(sharpness(40, {.point_handles = 0.9}), sharpness(20, {.point_handles = 0.9}));
}

TEST(Arap, no_step_with_point_handles_raises_the_energy)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    for (double lambda : {0.1, 0.5, 0.9}) {
        const Arap arap = bound(mesh, {.point_handles = lambda}, {shapes::ends(mesh, 2)[0], {{70}, {}}});
        const Poses poses{shapes::still(), shapes::turn({0, 0, 1}, 60, {6, 0, 0}, {0, 2, 1})};
        double before = std::numeric_limits<double>::infinity();
        for (int k = 0; k <= 16; ++k) {
            const SolveReport s = solve(arap, poses, {.max_iterations = k, .tolerance = 0.0}).report;
            EXPECT_LE(s.energy, before * (1 + 1e-12)) << "iteration " << k;
            before = s.energy;
        }
    }
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

TEST(Arap, a_region_painted_black_stays_solvable)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    ArapOptions options;
    options.rigidity.assign(mesh.vertex_count(), 1.0);
    for (int v : shapes::where(mesh, [](const Vector3& p) { return p.x() > 4 && p.x() < 8; }))
        options.rigidity[v] = 0.0;
    Arap arap(mesh, options);
    arap.set_handles(shapes::ends(mesh, 2));
    EXPECT_TRUE(solve(arap, bend(60)).positions.allFinite());
}

TEST(Arap, refuses_options_that_mean_nothing)
{
    const SurfaceMesh mesh = shapes::cube();
    for (double bad : {-1.0, nan, std::numeric_limits<double>::infinity()}) {
        EXPECT_THROW(Arap(mesh, {.smoothness = bad}), InvalidOption);
        EXPECT_THROW(Arap(mesh, {.tolerance = bad}), InvalidOption);
        EXPECT_THROW(Arap(mesh, {.rigidity = {bad}}), InvalidOption);
    }
    for (const std::vector<double>& bad : {std::vector{0.0}, std::vector(8, 0.0), {}, std::vector{1.0, 1.0}})
        EXPECT_THROW(Arap(mesh, {.rigidity = bad}), InvalidOption);
    EXPECT_THROW(Arap(mesh, {.max_iterations = 0}), InvalidOption);
    for (double bad : {-0.1, 1.0, 2.0, nan})
        EXPECT_THROW(Arap(mesh, {.point_handles = bad}), InvalidOption);
    EXPECT_THROW(Arap(mesh, {.cells = Cells::rims, .point_handles = 0.5}), InvalidOption);
    std::vector<double> paint(8, 1.0);
    paint[2] = -1;
    const auto make = [&] { Arap(mesh, {.rigidity = paint}); };
    expect_elements(refusal<InvalidOption>(make), Error::Element::vertex, {2});
}

TEST(Arap, energy_refuses_points_that_do_not_fit)
{
    const SurfaceMesh mesh = shapes::bar(4, 2);
    const Arap arap = bound(mesh, {}, shapes::ends(mesh, 1));
    Points broken = mesh.points();
    broken(3, 0) = nan;
    const Points other = Points::Zero(4, 3);
    EXPECT_THROW(arap.energy(view(other)), InvalidConstraint);
    EXPECT_THROW(arap.energy(view(broken)), InvalidConstraint);
}

} // namespace sinew::test_arap
