// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/arap.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_arap {

namespace {

using Cells = ArapOptions::Cells;

using calls::bend, calls::twist;

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

std::vector<double> painted(int n, int seed)
{
    shapes::Random random(seed);
    std::vector<double> values(n);
    for (double& value : values)
        value = std::pow(10.0, random.signed_unit());
    return values;
}

class Arap : public SurfaceFixture<sinew::Arap, ArapOptions>
{
public:
    static SurfaceTraits traits()
    {
        std::vector<SurfaceVariant> all{{"default", maker(), 2, false}};
        for (const Options& options : variants()) {
            const bool smooth = options.smoothness > 0; // alpha is scaled by the area of the whole mesh
            all.push_back({name_of(options), maker(options), smooth ? 2 : 1, !smooth});
        }
        all.push_back({"point handles", maker({.point_handles = 0.3}), 3, false});
        SurfaceTraits made = nonlinear("Arap", all);
        made.iterative = true;
        made.other = maker({.rigidity = {2.0}});
        return made;
    }
};

} // namespace

INSTANTIATE_TEST_SUITE_P(Arap, SurfaceContract, testing::Values(Arap::traits()));

TEST_F(Arap, reproduces_the_known_octahedron)
{
    // -z held, +z lifted to 1.5: the equator keeps its radius and rises to the middle, nothing
    // turns, and eight edges are 1/4 too long or short on both ends: 16 / 16 / sqrt 3.
    Method arap(shapes::octahedron(), {.smoothness = 0, .max_iterations = 500, .tolerance = 1e-15});
    arap.set_handles({{{5}, {}}, {{4}, {}}});
    const Solution lifted = solve(arap, {shapes::still(), shapes::shift(0, 0, 0.5)});
    EXPECT_NEAR(lifted.report.energy, 0.5773502692, 1e-10);
    for (int v = 0; v < 4; ++v) {
        // E is flat at its minimum: half the digits of E in the positions.
        EXPECT_NEAR(lifted.positions(v, 2), 0.25, 1e-7);
        EXPECT_NEAR(lifted.positions.row(v).head<2>().norm(), 1.0, 1e-7);
    }
}

TEST_F(Arap, energy_never_rises_with_painted_rigidity_or_point_handles)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    for (Options options : variants()) {
        SCOPED_TRACE(name_of(options));
        options.rigidity = painted(mesh.vertex_count(), 5);
        const Method arap = bound(mesh, options, shapes::ends(mesh, 2));
        for (const Poses& poses : {bend(120), twist(135), Poses{shapes::still(), shapes::shift(-6, 8, 0)}})
            calls::expect_falling_energy(arap, poses);
    }
    for (double lambda : {0.1, 0.5, 0.9})
        calls::expect_falling_energy(
            bound(mesh, {.point_handles = lambda}, {shapes::ends(mesh, 2)[0], {{70}, {}}}),
            {shapes::still(), shapes::turn({0, 0, 1}, 60, {6, 0, 0}, {0, 2, 1})});
}

TEST_F(Arap, is_near_its_minimum_after_ten_iterations)
{
    const SurfaceMesh mesh = shapes::bar(20, 5);
    const Method arap = bound(mesh, {}, shapes::ends(mesh, 1));
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

TEST_F(Arap, six_iterations_settle_soft_bends_and_twists)
{
    // A slab bends softly; steps in the metric alone leave .2 to .4 % of the box after six iterations.
    for (const SurfaceMesh& mesh : {shapes::bar(40, 10), shapes::bar(60, 6)}) {
        const double length = mesh.points().col(0).maxCoeff(), size = shapes::size(mesh.points());
        const Method arap = bound(mesh, {}, shapes::ends(mesh, 3));
        for (const Poses& poses : {bend(60, length), Poses{shapes::still(), shapes::turn({1, 0, 0}, 90)}}) {
            const Points limit = solve(arap, poses, {.max_iterations = 600, .tolerance = 1e-12}).positions;
            const Points six = solve(arap, poses, {.max_iterations = 6, .tolerance = 0.0}).positions;
            EXPECT_LT(shapes::distance(six, limit), 1e-3 * size);
        }
    }
}

TEST_F(Arap, last_bits_of_poses_and_of_the_rest_shape_stay_small)
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
        const Method arap = bound(mesh, {}, handles);
        const Method other = bound(shapes::moved(mesh, noise(mesh.points(), 3e-8 * size)), {}, handles);
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

TEST_F(Arap, a_warm_drag_stays_near_the_answer_from_the_poses_alone)
{
    const SurfaceMesh mesh = shapes::bar(16, 4);
    const Method arap = bound(mesh, {}, shapes::ends(mesh, 2));
    Points shape = mesh.points();
    for (int k = 1; k <= 20; ++k)
        shape = solve(arap, bend(4.5 * k, 16), {.start = view(shape), .max_iterations = 4}).positions;
    const Points cold = solve(arap, bend(90, 16)).positions;
    EXPECT_LT(shapes::distance(shape, cold),
              0.02 * shapes::size(mesh.points())); // the study: .01 rms at worst
}

TEST_F(Arap, a_start_at_the_answer_stays_there)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    const Method arap = bound(mesh, {.tolerance = 1e-10}, shapes::ends(mesh, 2));
    const Solution answer = solve(arap, bend(60), {.max_iterations = 300});
    const Solution again = solve(arap, bend(60), {.start = view(answer.positions)});
    EXPECT_LT(shapes::distance(again.positions, answer.positions),
              1e-3 * 12); // E settles to 1e-10: half its digits
    EXPECT_LE(again.report.energy, answer.report.energy * (1 + 1e-6));
}

TEST_F(Arap, a_scaled_rigidity_scales_the_energy_alone)
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

TEST_F(Arap, painted_rigidity_keeps_its_region_stiffer)
{
    const SurfaceMesh mesh = shapes::bar(16, 4);
    // Length of the middle third's lines along x: stretch between the ends has to go elsewhere.
    const auto middle_length = [&](double rigidity) {
        Options options;
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

TEST_F(Arap, a_mirrored_handle_leaves_rotations_and_energy_sound)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    const Poses mirrored{shapes::still(), shapes::affine(Vector3(1, 1, -1).asDiagonal())};
    for (const ArapOptions& options : variants()) {
        const Method arap = bound(mesh, options, shapes::ends(mesh, 2));
        const Solution s = solve(arap, mirrored);
        ASSERT_TRUE(s.positions.allFinite());
        // A mirrored cell fits no rotation: the energy cannot be that of a rigid motion.
        EXPECT_GT(s.report.energy, 1.0);
    }
}

} // namespace sinew::test_arap
