// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/nonlinear/rigid_cells.h"

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
using Answer = RigidCells::Answer;
using Start = RigidCells::Start;

const SurfaceMesh bar = shapes::bar(24, 6);

Poses bent(double degrees)
{
    return {shapes::still(), shapes::turn({0, 1, 0}, degrees, {12, 0, 0}, {-3, 0, 0})};
}

Poses twisted(double degrees) { return {shapes::still(), shapes::turn({1, 0, 0}, degrees)}; }

struct Bound : RigidCells
{
    explicit Bound(const SurfaceMesh& mesh = bar, const RigidCellsOptions& options = {.cells = 300})
        : RigidCells(mesh, shapes::held_ends(mesh, 2.0), options)
    {
        bind(view(mesh.points()));
    }
};

SpaceTraits traits()
{
    const auto make = [](RigidCellsOptions options) {
        return
            [options] { return std::make_shared<RigidCells>(bar, shapes::held_ends(bar, 2.0), options); };
    };
    return {.name = "RigidCells",
            .variants = {{"300 cells", make({.cells = 300})}, {"one size", make({.cells = 120, .levels = 0})}},
            .control = shapes::held_ends(bar, 2.0).points,
            .points = bar.points(),
            .follow = 1.5,
            .outside = Vector3(-5, 0, 0),
            .other = make({.cells = 301})};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(RigidCells, SpaceContract, testing::Values(traits()));

TEST(RigidCells, one_rigid_motion_is_exact_whatever_the_cells)
{
    for (const RigidCellsOptions options :
         {RigidCellsOptions{.cells = 40, .levels = 0}, {.cells = 300}, {.cells = 2000, .levels = 3}}) {
        const Bound method(bar, options);
        for (const double angle : {10.0, 170.0, 180.0}) {
            const Pose rigid = shapes::turn({1, 2, -1}, angle, {5, 1, 0}, {3, -4, 2});
            EXPECT_LT(apart(warped(method, {rigid, rigid}), shapes::transformed(bar.points(), rigid)), 1e-11)
                << options.cells << " cells, " << angle << " degrees";
        }
        std::cout << method.cells().centres.rows() << " cells of " << options.cells << "\n";
    }
}

TEST(RigidCells, two_unrelated_starts_meet)
{
    const Bound method;
    for (const Poses& poses : {bent(90), twisted(135)}) {
        const Answer one = method.answer(poses, Start::cascade, 1e-12, 4000),
                     other = method.answer(poses, Start::rest, 1e-12, 4000);
        EXPECT_TRUE(one.report.converged && other.report.converged);
        EXPECT_NEAR(one.report.energy, other.report.energy, 1e-6 * one.report.energy);
        EXPECT_LT(shapes::distance(one.centres, other.centres), 1e-2); // of a bar of length 24
        const Answer quick = method.answer(poses, Start::cascade, 1e-4, 40);
        std::cout << one.report.iterations << " " << other.report.iterations << " quick "
                  << quick.report.iterations << " rejected " << quick.report.rejected << " E "
                  << one.report.energy << " quick E " << quick.report.energy << " off "
                  << shapes::distance(quick.centres, one.centres) << "\n";
    }
}

} // namespace sinew
