// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/mean_value.h"

#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

namespace sinew::test_mean_value {

namespace {

using cages::doubles;

SpaceTraits traits()
{
    const SurfaceMesh cage = shapes::u_prism();
    return {.name = "MeanValue",
            .variants = {cages::variant<MeanValue>("double", cage, doubles)},
            .control = cage.points(),
            .points = shapes::points_around(cage, 600, 1.3),
            .similarity = 1e-11,
            .affine = 1e-11,
            .other = [cage] { return std::make_shared<MeanValue>(Cage(cage)); }};
}

} // namespace

// What its weights promise is in tests/bindings/spaces/test_cage_weights.py.
INSTANTIATE_TEST_SUITE_P(MeanValue, SpaceContract, testing::Values(traits()));

} // namespace sinew::test_mean_value
