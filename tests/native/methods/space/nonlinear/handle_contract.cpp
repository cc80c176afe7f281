// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/native/methods/space/nonlinear/handle_contract.h"

#include "tests/native/allocations.h"
#include "tests/native/methods/space/nonlinear/handle_shapes.h"
#include "tests/native/refusals.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {

namespace {

using shapes::apart;
using shapes::warped;
using Start = HandleTraits::Start;

const SurfaceMesh bar = shapes::bar(24, 6);

} // namespace

std::shared_ptr<HandleMethod> HandleContract::bound(const SurfaceMesh& mesh) const
{
    const std::shared_ptr<HandleMethod> method = traits().make(mesh, shapes::held_ends(mesh, 2.0));
    method->bind(view(mesh.points()));
    return method;
}

TEST_P(HandleContract, one_rigid_motion_of_all_handles_moves_all_by_it)
{
    const std::shared_ptr<HandleMethod> method = bound(bar);
    for (const double angle : {10.0, 170.0, 180.0}) {
        const Pose rigid = shapes::turn({1, 2, -1}, angle, {5, 1, 0}, {3, -4, 2});
        EXPECT_LT(apart(warped(*method, {rigid, rigid}), shapes::transformed(bar.points(), rigid)), 1e-11)
            << angle;
    }
}

TEST_P(HandleContract, two_unrelated_starts_meet)
{
    const std::shared_ptr<HandleMethod> method = bound(bar);
    for (const Poses& poses : {shapes::bent(90), shapes::twisted(135)}) {
        const auto one = traits().answer(*method, poses, Start::usual, 1e-12, 4000),
                   other = traits().answer(*method, poses, Start::other, 1e-12, 4000);
        EXPECT_TRUE(one.report.converged && other.report.converged);
        EXPECT_NEAR(one.report.energy, other.report.energy, 1e-6 * one.report.energy);
        EXPECT_LT((one.unknowns - other.unknowns).cwiseAbs().maxCoeff(), traits().meet);
    }
}

TEST_P(HandleContract, handles_are_met_exactly_and_smoothly)
{
    const std::shared_ptr<HandleMethod> method = bound(bar);
    const Poses poses = shapes::bent(60);
    const Points shape = warped(*method, poses);
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

TEST_P(HandleContract, ten_warps_factorise_nothing)
{
    if (!allocations::counted())
        GTEST_SKIP() << "this build does not count allocations";
    const std::shared_ptr<HandleMethod> method = bound(bar);
    Points out(bar.vertex_count(), 3);
    method->warp_poses(shapes::bent(20), {}, out.data());
    // A factor of the nodes or cells, or their table, takes more.
    const allocations::Count count(100000);
    for (int k = 0; k < 10; ++k)
        method->warp_poses(shapes::bent(2.0 * k), {}, out.data());
    EXPECT_EQ(count.so_far(), 0);
}

TEST_P(HandleContract, never_ends_with_a_higher_energy)
{
    const std::shared_ptr<HandleMethod> method = bound(bar);
    for (const Start start : {Start::usual, Start::other}) {
        double last = std::numeric_limits<double>::infinity();
        for (int steps = 1; steps < 12; ++steps) {
            const double energy =
                traits().answer(*method, shapes::twisted(120), start, 0.0, steps).report.energy;
            EXPECT_LE(energy, last * (1 + 1e-12)) << steps;
            last = energy;
        }
    }
}

TEST_P(HandleContract, moves_every_part_and_any_points)
{
    SurfaceMesh many = bar;
    const SurfaceMesh ball = shapes::sphere(1);
    for (int k = 0; k < 12; ++k) // beads on the bar
        many = shapes::joined(many, shapes::moved(ball, 0.3 * ball.points()), {2.0 * k, 3.1, 0});
    const std::shared_ptr<HandleMethod> method = bound(many);
    const Pose rigid = shapes::turn({1, 1, 0}, 170, {3, 0, 0});
    EXPECT_LT(apart(warped(*method, {rigid, rigid}), shapes::transformed(many.points(), rigid)), 1e-11);
    const Points bent_shape = warped(*method, shapes::bent(60));
    const double size = shapes::size(0.3 * ball.points());
    for (int k = 0; k < 12; ++k) { // beads stay in shape
        const Points bead =
            bent_shape.middleRows(bar.vertex_count() + k * ball.vertex_count(), ball.vertex_count());
        EXPECT_NEAR(shapes::size(bead), size, 0.25 * size) << k;
    }
    const std::shared_ptr<HandleMethod> points = bound(SurfaceMesh(bar.points(), {}, {}));
    EXPECT_LT(apart(warped(*points, {rigid, rigid}), shapes::transformed(bar.points(), rigid)), 1e-11);
}

TEST_P(HandleContract, a_control_without_a_region_turns_the_shape)
{
    Points ends(2, 3);
    ends << 0, 0, 0, 24, 0, 0;
    const std::shared_ptr<HandleMethod> method = traits().make(bar, HandlePoints(view(ends)));
    method->bind(view(bar.points()));
    const Points shape = warped(*method, shapes::twisted(90));
    double angle = 0.0;
    for (int v = 0; v < bar.vertex_count(); ++v)
        if (bar.point(v) == Vector3(23, 3, 0))
            angle = std::atan2(shape(v, 2), shape(v, 1)) * 180 / shapes::pi;
    EXPECT_GT(angle, traits().turns_alone);
}

TEST_P(HandleContract, a_control_that_moved_along_does_nothing_more)
{
    const std::shared_ptr<HandleMethod> method = bound(bar);
    const Pose turn = shapes::turn({0, 0, 1}, 40, {12, 0, 0});
    const Poses poses{shapes::still(), turn};
    Points entering = bar.points();
    for (int v = 0; v < bar.vertex_count(); ++v)
        if (bar.point(v).x() >= 12.0)
            entering.row(v) = apply(turn, bar.point(v)).transpose();
    EXPECT_LT(apart(warped(*method, poses, view(entering), {false, true}), entering), 1e-12);
    EXPECT_GT(apart(warped(*method, poses, view(entering)), entering), 0.05);
    EXPECT_THROW(warped(*method, poses, view(entering), {true}), InvalidConstraint);
}

TEST_P(HandleContract, refuses_by_name)
{
    for (const auto& make : traits().out_of_range)
        EXPECT_THROW(make(), InvalidOption);
    Poses poses = shapes::bent(30);
    poses[1](2, 3) = std::numeric_limits<double>::quiet_NaN();
    const std::shared_ptr<HandleMethod> method = bound(bar);
    expect_elements(refusal<InvalidConstraint>([&] { warped(*method, poses); }), Error::Element::handle, {1});
    EXPECT_THROW(warped(*method, {shapes::still()}), InvalidConstraint);
    const std::shared_ptr<HandleMethod> unbound = traits().make(bar, shapes::held_ends(bar, 2.0));
    EXPECT_THROW(unbound->network(shapes::bent(1)), InvalidConstraint);
}

} // namespace sinew
