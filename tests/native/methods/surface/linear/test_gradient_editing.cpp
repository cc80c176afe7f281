// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/gradient_editing.h"

#include "tests/native/methods/surface/fixture.h"

#include <gtest/gtest.h>

namespace sinew::test_gradient_editing {

namespace {

using Fixture = SurfaceFixture<GradientEditing, GradientEditingOptions>;

SurfaceTraits traits()
{
    SurfaceTraits made =
        Fixture::linear("GradientEditing", {{"harmonic", Fixture::maker({Field::harmonic}), 1, true, 1e-11},
                                            {"geodesic", Fixture::maker({Field::geodesic}), 1, true, 1e-11}});
    made.translation = 1e-11;
    made.rigid = 1e-12; // a condition of 1e3
    made.similar = 1e-10;
    made.rides = 1e-11;
    made.apart = 1e-12;
    made.parts_apart = true;
    made.half_turns = 81;
    made.updates = "field";
    made.updated = Fixture::maker({Field::geodesic});
    return made;
}

} // namespace

INSTANTIATE_TEST_SUITE_P(GradientEditing, SurfaceContract, testing::Values(traits()));

TEST(GradientEditing, on_the_multigrid_ends_within_a_product_when_cancelled_and_begins_from_a_shape)
{
    Fixture::on_the_multigrid({.solver = SystemSolver::factor}, {.solver = SystemSolver::multigrid});
}

} // namespace sinew::test_gradient_editing
