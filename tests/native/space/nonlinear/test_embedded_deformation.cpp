// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/nonlinear/embedded_deformation.h"

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

} // namespace sinew
