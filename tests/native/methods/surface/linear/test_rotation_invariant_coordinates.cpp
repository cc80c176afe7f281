// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/rotation_invariant_coordinates.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_rotation_invariant_coordinates {

namespace {

class RotationInvariantCoordinates
    : public SurfaceFixture<sinew::RotationInvariantCoordinates, RotationInvariantCoordinatesOptions>
{
public:
    static SurfaceTraits traits()
    {
        SurfaceTraits made =
            linear("RotationInvariantCoordinates", {{"cotan", maker({Discretization::cotan})},
                                                    {"uniform", maker({Discretization::uniform})}});
        made.translation = 1e-11;
        made.rigid = 1e-12; // a condition of 1e3
        made.similar = 1e-10;
        made.other = maker({Discretization::uniform});
        return made;
    }
};

} // namespace

INSTANTIATE_TEST_SUITE_P(RotationInvariantCoordinates, SurfaceContract,
                         testing::Values(RotationInvariantCoordinates::traits()));

TEST_F(RotationInvariantCoordinates, between_handles_at_half_a_turn_follow_the_mean_angle)
{
    const SurfaceMesh mesh = shapes::hill(10, 9);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    SolveReport report;
    const auto at = [&](double degrees) {
        return solved(mesh, handles, {.poses = {shapes::still(), shapes::turn({1, 0, 0}, degrees)}}, {},
                      &report);
    };
    at(150);
    EXPECT_EQ(report.half_turns, 0);
    const Points half = at(180);
    EXPECT_GT(report.half_turns, 0);
    EXPECT_LT(report.half_turns, mesh.vertex_count() / 2) << "those in the middle";
    for (double rounding : {-1e-11, 1e-11}) // degrees; rounding does not choose the way
        EXPECT_LT(shapes::distance(at(180 + rounding), half), 1e-8);
}

} // namespace sinew::test_rotation_invariant_coordinates
