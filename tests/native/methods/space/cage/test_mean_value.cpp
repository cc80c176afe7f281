// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/mean_value.h"

#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

namespace sinew::test_mean_value {

namespace {

SpaceTraits traits()
{
    const SurfaceMesh cage = shapes::u_prism();
    SpaceTraits made = cages::traits<MeanValue>("MeanValue", cage, shapes::points_around(cage, 600, 1.3),
                                                cages::doubles, {});
    made.similarity = made.affine = 1e-11;
    return made;
}

} // namespace

// What its weights promise is in tests/bindings/spaces/test_cage_weights.py.
INSTANTIATE_TEST_SUITE_P(MeanValue, SpaceContract, testing::Values(traits()));

} // namespace sinew::test_mean_value
