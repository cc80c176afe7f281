// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/arap.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_arap {

namespace {

using Cells = ArapOptions::Cells;

using Fixture = SurfaceFixture<Arap, ArapOptions>;

SurfaceTraits traits()
{
    std::vector<SurfaceVariant> all{{"default", Fixture::maker(), 2, false}};
    for (double smoothness : {0.0, 5e-4, 0.1})
        for (Cells cells : {Cells::spokes, Cells::rims}) {
            const bool smooth = smoothness > 0; // alpha is scaled by the area of the whole mesh
            all.push_back({(cells == Cells::rims ? "rims, smoothness " : "spokes, smoothness ") +
                               std::to_string(smoothness),
                           Fixture::maker({.smoothness = smoothness, .cells = cells}), smooth ? 2 : 1,
                           !smooth});
        }
    all.push_back({"multigrid", Fixture::maker({.solver = SystemSolver::multigrid}), 2, false});
    all.push_back({"point handles", Fixture::maker({.point_handles = 0.3}), 3, false});
    SurfaceTraits made = Fixture::nonlinear("Arap", all);
    made.iterative = true;
    made.other = Fixture::maker({.rigidity = {2.0}});
    return made;
}

} // namespace

// More of it is in tests/bindings/surfaces/test_nonlinear.py.
INSTANTIATE_TEST_SUITE_P(Arap, SurfaceContract, testing::Values(traits()));

TEST(Arap, on_the_multigrid_ends_within_a_product_when_cancelled_and_begins_from_a_shape)
{
    Fixture::on_the_multigrid({.solver = SystemSolver::factor}, {.solver = SystemSolver::multigrid});
}

} // namespace sinew::test_arap
