// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/nonlinear/embedded_deformation.h"

#include "tests/native/allocations.h"
#include "tests/native/refusals.h"
#include "tests/native/space/contract.h"
#include "tests/native/space/nonlinear/handle_shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

namespace sinew {

namespace {

using shapes::apart;
using shapes::warped;
using Answer = EmbeddedDeformation::Answer;
using Start = EmbeddedDeformation::Start;

const SurfaceMesh bar = shapes::bar(24, 6);

Poses bent(double degrees)
{
    return {shapes::still(), shapes::turn({0, 1, 0}, degrees, {12, 0, 0}, {-3, 0, 0})};
}

Poses twisted(double degrees) { return {shapes::still(), shapes::turn({1, 0, 0}, degrees)}; }

struct Bound : EmbeddedDeformation
{
    explicit Bound(const SurfaceMesh& mesh = bar, const EmbeddedDeformationOptions& options = {.nodes = 60})
        : EmbeddedDeformation(mesh, shapes::held_ends(mesh, 2.0), options)
    {
        bind(view(mesh.points()));
    }
};

SpaceTraits traits()
{
    const auto make = [](EmbeddedDeformationOptions options) {
        return [options] {
            return std::make_shared<EmbeddedDeformation>(bar, shapes::held_ends(bar, 2.0), options);
        };
    };
    return {.name = "EmbeddedDeformation",
            .variants = {{"60 nodes", make({.nodes = 60})},
                         {"stiff", make({.nodes = 30, .rotation = 10.0, .pulls = 1e4})}},
            .control = shapes::held_ends(bar, 2.0).points,
            .points = bar.points(),
            .follow = 1.5,
            .deforms_what_enters = 1e-10, // of float32 solves, three of which leave less than that
            .other = make({.nodes = 61})};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(EmbeddedDeformation, SpaceContract, testing::Values(traits()));

TEST(EmbeddedDeformation, rigid_handles_cost_nothing_and_move_all_rigidly)
{
    const Bound method;
    for (const double angle : {10.0, 170.0, 180.0}) {
        const Pose rigid = shapes::turn({1, 2, -1}, angle, {5, 1, 0}, {3, -4, 2});
        const Answer found = method.answer({rigid, rigid}, Start::handles, 1e-4, 40);
        EXPECT_LT(found.report.energy, 1e-18) << angle; // the energy of a bend is about 1
        EXPECT_LT(apart(warped(method, {rigid, rigid}), shapes::transformed(bar.points(), rigid)), 1e-12);
    }
}

TEST(EmbeddedDeformation, two_unrelated_starts_meet)
{
    const Bound method;
    for (const Poses& poses : {bent(90), twisted(135)}) {
        const Answer one = method.answer(poses, Start::handles, 1e-12, 4000),
                     other = method.answer(poses, Start::no_rotations, 1e-12, 4000);
        EXPECT_TRUE(one.report.converged && other.report.converged);
        EXPECT_NEAR(one.report.energy, other.report.energy, 1e-6 * one.report.energy);
        EXPECT_LT((one.unknowns - other.unknowns).cwiseAbs().maxCoeff(), 1e-3); // of a bar of length 24
        const Answer quick = method.answer(poses, Start::handles, 1e-4, 40);
        std::cout << one.report.iterations << " " << other.report.iterations << " quick "
                  << quick.report.iterations << " rejected " << quick.report.rejected << " E "
                  << one.report.energy << " quick E " << quick.report.energy << " off "
                  << (quick.unknowns - one.unknowns).cwiseAbs().maxCoeff() << "\n";
    }
}

TEST(EmbeddedDeformation, handles_are_met_exactly_and_smoothly)
{
    const Bound method;
    const Poses poses = bent(60);
    const Points shape = warped(method, poses);
    double step = 0.0;
    for (int v = 0; v < bar.vertex_count(); ++v) {
        const Vector3 at = bar.point(v);
        if (at.x() > 2.0 && at.x() < 22.0)
            continue;
        const Vector3 wanted = apply(poses[at.x() > 12.0 ? 1 : 0], at);
        EXPECT_LT((shape.row(v).transpose() - wanted).norm(), 1e-13 * 24) << v;
    }
    for (const auto& [a, b] : bar.edges()) // of length 1
        step = std::max(step, (shape.row(a) - shape.row(b)).norm());
    EXPECT_LT(step, 1.6) << "no edge tears at the border of a handle";
}

TEST(EmbeddedDeformation, ten_warps_factorise_nothing)
{
    if (!allocations::counted())
        GTEST_SKIP() << "this build does not count allocations";
    const Bound method;
    Points out(bar.vertex_count(), 3);
    method.warp_poses(bent(20), {}, out.data());
    // A factor of the nodes or cells, or their table, takes more.
    const allocations::Count count(100000);
    for (int k = 0; k < 10; ++k)
        method.warp_poses(bent(2.0 * k), {}, out.data());
    EXPECT_EQ(count.so_far(), 0);
}

TEST(EmbeddedDeformation, never_ends_with_a_higher_energy)
{
    const Bound method;
    double last = std::numeric_limits<double>::infinity();
    for (int steps = 1; steps < 12; ++steps) {
        const double energy = method.answer(twisted(120), Start::no_rotations, 0.0, steps).report.energy;
        EXPECT_LE(energy, last * (1 + 1e-12)) << steps;
        last = energy;
    }
}

TEST(EmbeddedDeformation, moves_every_part_and_any_points)
{
    SurfaceMesh many = bar;
    const SurfaceMesh ball = shapes::sphere(1);
    for (int k = 0; k < 12; ++k) // beads on the bar
        many = shapes::joined(many, shapes::moved(ball, 0.3 * ball.points()), {2.0 * k, 3.1, 0});
    const Bound method(many);
    const Pose rigid = shapes::turn({1, 1, 0}, 170, {3, 0, 0});
    EXPECT_LT(apart(warped(method, {rigid, rigid}), shapes::transformed(many.points(), rigid)), 1e-11);
    const Points bent_shape = warped(method, bent(60));
    const double size = shapes::size(0.3 * ball.points());
    for (int k = 0; k < 12; ++k) { // beads stay in shape
        const Points bead =
            bent_shape.middleRows(bar.vertex_count() + k * ball.vertex_count(), ball.vertex_count());
        EXPECT_NEAR(shapes::size(bead), size, 0.25 * size) << k;
    }
    const SurfaceMesh cloud(bar.points(), {}, {});
    const Bound points(cloud);
    EXPECT_LT(apart(warped(points, {rigid, rigid}), shapes::transformed(bar.points(), rigid)), 1e-11);
}

TEST(EmbeddedDeformation, a_control_without_a_region_turns_the_shape)
{
    HeldPoints held;
    held.points.resize(2, 3);
    held.points << 0, 0, 0, 24, 0, 0;
    held.counts = {1, 1};
    EmbeddedDeformation method(bar, held, {.nodes = 60});
    method.bind(view(bar.points()));
    const Points shape = warped(method, twisted(90));
    double angle = 0.0;
    for (int v = 0; v < bar.vertex_count(); ++v)
        if (bar.point(v) == Vector3(23, 3, 0))
            angle = std::atan2(shape(v, 2), shape(v, 1)) * 180 / shapes::pi;
    EXPECT_GT(angle, 70) << "near the end, the bar turns with the control";
}

TEST(EmbeddedDeformation, a_control_that_moved_along_does_nothing_more)
{
    const Bound method;
    const Pose turn = shapes::turn({0, 0, 1}, 40, {12, 0, 0});
    Points entering = bar.points();
    for (int v = 0; v < bar.vertex_count(); ++v)
        if (bar.point(v).x() >= 12.0)
            entering.row(v) = apply(turn, bar.point(v)).transpose();
    EXPECT_LT(apart(warped(method, {shapes::still(), turn}, view(entering), {false, true}), entering), 1e-12);
    EXPECT_GT(apart(warped(method, {shapes::still(), turn}, view(entering)), entering), 0.05);
    EXPECT_THROW(warped(method, {shapes::still(), turn}, view(entering), {true}), InvalidConstraint);
}

TEST(EmbeddedDeformation, refuses_by_name)
{
    using Options = EmbeddedDeformationOptions;
    const HeldPoints held = shapes::held_ends(bar, 2.0);
    const auto make = [&](Options options) { (void)EmbeddedDeformation(bar, held, options); };
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Options& options : std::vector<Options>{{.nodes = 0},
                                                       {.rotation = 0},
                                                       {.regularity = nan},
                                                       {.pulls = -1},
                                                       {.max_iterations = 0},
                                                       {.tolerance = nan}})
        EXPECT_THROW(make(options), InvalidOption);
    Poses poses = bent(30);
    poses[1](2, 3) = nan;
    const Bound method;
    expect_elements(refusal<InvalidConstraint>([&] { warped(method, poses); }), Error::Element::handle, {1});
    EXPECT_THROW(warped(method, {shapes::still()}), InvalidConstraint);
    EmbeddedDeformation unbound(bar, held);
    EXPECT_THROW(unbound.network(bent(1)), InvalidConstraint);
}

} // namespace sinew
