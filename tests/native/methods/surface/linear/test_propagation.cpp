// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/propagation.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_propagation {

namespace {

class Propagation : public SurfaceFixture<sinew::Propagation, PropagationOptions>
{
public:
    static SurfaceTraits traits()
    {
        SurfaceTraits made =
            linear("Propagation", {{"harmonic", maker(), 1, true, 1e-12},
                                   {"geodesic", maker({.field = Field::geodesic}), 0, true, 1e-12},
                                   {"euclidean", maker({.field = Field::euclidean}), 0, true, 1e-12}});
        made.translation = 1e-12;
        made.rigid = 1e-13;
        made.similar = 1e-10;
        made.rides = 1e-12;
        made.half_turns = 81;
        made.updates = "transfer";
        made.updated = maker({.transfer = {0.0, 0.2, 1.0}});
        return made;
    }
};

} // namespace

INSTANTIATE_TEST_SUITE_P(Propagation, SurfaceContract, testing::Values(Propagation::traits()));

TEST_F(Propagation, one_handle_alone_takes_everything_along_whatever_the_curve)
{
    const SurfaceMesh mesh = shapes::hill(9, 8);
    const Pose pose =
        shapes::affine(Vector3(1.2, 0.8, -2).asDiagonal() * shapes::rotation({1, 2, 0}, 30), {1, 2, 3});
    EXPECT_LT(
        shapes::distance(solved(mesh, {{{45}, {0.3}}}, {.poses = {pose}}, {.transfer = {0.0, 0.3, 1.0}}),
                         shapes::transformed(mesh.points(), pose)),
        1e-12);
}

} // namespace sinew::test_propagation
