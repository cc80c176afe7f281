// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/positive_mean_value.h"

#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

namespace sinew::test_positive_mean_value {

namespace {

PositiveMeanValueOptions exact()
{
    PositiveMeanValueOptions options;
    options.weights = cages::doubles;
    return options;
}

PositiveMeanValueOptions rays(int count)
{
    PositiveMeanValueOptions options = exact();
    options.exact = false;
    options.directions = count;
    return options;
}

SpaceTraits traits()
{
    const SurfaceMesh u = cages::u_prism();
    return {.name = "PositiveMeanValue",
            .variants = {cages::variant<PositiveMeanValue>("exact", u, exact()),
                         cages::variant<PositiveMeanValue>("rays", u, rays(1024))},
            .control = u.points(),
            .points = cages::inside_u_prism(600, 1e-3),
            .affine = 2e-10,
            .outside = Vector3(1.5, 2, 0.5),
            .refuses_outside = true,
            .other = [u] { return std::make_shared<PositiveMeanValue>(Cage(u), rays(512)); }};
}

} // namespace

// What its weights promise is in tests/bindings/spaces/test_cage_weights.py.
INSTANTIATE_TEST_SUITE_P(PositiveMeanValue, SpaceContract, testing::Values(traits()));

} // namespace sinew::test_positive_mean_value
