// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/positive_mean_value.h"

#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

namespace sinew::test_positive_mean_value {

namespace {

SpaceTraits traits()
{
    PositiveMeanValueOptions exact, rays, fewer;
    exact.weights = rays.weights = fewer.weights = cages::doubles;
    rays.exact = fewer.exact = false;
    rays.directions = 1024;
    fewer.directions = 512;
    const SurfaceMesh cage = shapes::u_prism();
    SpaceTraits made = cages::refusing(cages::traits<PositiveMeanValue>(
        "PositiveMeanValue", cage, cages::inside_u_prism(600, 1e-3), exact, fewer));
    made.variants.push_back(cages::variant<PositiveMeanValue>("rays", cage, rays));
    made.affine = 2e-10;
    return made;
}

} // namespace

// What its weights promise is in tests/bindings/spaces/test_cage_weights.py.
INSTANTIATE_TEST_SUITE_P(PositiveMeanValue, SpaceContract, testing::Values(traits()));

} // namespace sinew::test_positive_mean_value
