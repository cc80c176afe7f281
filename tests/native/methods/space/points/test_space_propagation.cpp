// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/points/space_propagation.h"

#include "tests/native/methods/space/contract.h"
#include "tests/native/methods/space/handle_points/fixture.h"

#include <gtest/gtest.h>

namespace sinew::test_space_propagation {

namespace {

using handles::random_points, handles::regions;

SpaceTraits traits()
{
    const HandlePoints handles = regions(30);
    return {.name = "SpacePropagation",
            .variants = {{"straight", [=] { return std::make_shared<SpacePropagation>(handles); }},
                         {"eased",
                          [=] {
                              return std::make_shared<SpacePropagation>(
                                  handles, SpacePropagationOptions{{0.0, 0.1, 0.9, 1.0}});
                          }}},
            .control = handles.control(),
            .points = random_points(500, 3.0, 4),
            .translation{}, // not with another transfer
            .follow = 6.0,
            .other = [=] {
                return std::make_shared<SpacePropagation>(handles, SpacePropagationOptions{{0.0, 0.5, 1.0}});
            }};
}

} // namespace

// What it does to points is in tests/bindings/oracles/test_oracles_points.py.
INSTANTIATE_TEST_SUITE_P(SpacePropagation, SpaceContract, testing::Values(traits()));

} // namespace sinew::test_space_propagation
