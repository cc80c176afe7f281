// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/rotation_invariant_coordinates.h"

#include "native/methods/surface/linear/gradient_editing.h"
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
        made.similar = made.scaled = 1e-10;
        made.other = maker({Discretization::uniform});
        return made;
    }
};

} // namespace

INSTANTIATE_TEST_SUITE_P(RotationInvariantCoordinates, SurfaceContract,
                         testing::Values(RotationInvariantCoordinates::traits()));

TEST_F(RotationInvariantCoordinates, of_handles_that_do_not_turn_are_gradients_that_do_not_turn)
{
    const SurfaceMesh mesh = shapes::hill(9, 8);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const Poses lifted{shapes::still(), shapes::shift(-2, 1, 4)};
    GradientEditing gradients(mesh);
    gradients.set_handles(handles);
    Points expected;
    gradients.solve({lifted}, expected);
    EXPECT_LT(shapes::distance(solved(mesh, handles, {.poses = lifted}), expected), 1e-12);
}

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

TEST_F(RotationInvariantCoordinates, take_the_rotation_of_an_affine_map_and_leave_its_scale_at_the_handle)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const Matrix3 R = shapes::rotation({0, 1, 0}, 40);
    const Points scaled = solved(mesh, handles, {.poses = {shapes::still(), shapes::affine(1.5 * R)}}),
                 plain = solved(mesh, handles, {.poses = {shapes::still(), shapes::affine(R)}});
    // Only held vertices differ, and what lies between them is as smooth as it can be.
    const MatrixX force = laplacian_matrix(mesh, Discretization::cotan) * (scaled - plain);
    const Regions regions(handles, connected_components(mesh));
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (regions.is_free(v)) {
            EXPECT_LT(force.row(v).norm(), 1e-12);
        } else if (regions.hard(v) == 1) {
            EXPECT_LT((scaled.row(v).transpose() - 1.5 * R * mesh.point(v)).norm(), 1e-13);
        }
    }
}

} // namespace sinew::test_rotation_invariant_coordinates
