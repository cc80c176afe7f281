// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/points/wires.h"

#include "tests/native/methods/space/contract.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sinew::test_wires {

namespace {

SpaceTraits traits()
{
    Points rest(21, 3); // a quarter of a circle, and a line
    for (int k = 0; k < 12; ++k)
        rest.row(k) << std::cos(shapes::pi * k / 22), std::sin(shapes::pi * k / 22), 0.0;
    for (int k = 0; k < 9; ++k)
        rest.row(12 + k) << 0.25 * k - 1, -0.5, 0.5;
    WireOptions wide{.counts = {12, 9}, .radius = {0.8, 0.6}}, plain = wide, limited = wide;
    plain.smoothing = 0.0;
    plain.exponent = 3.0;
    plain.rotation = {0.5};
    limited.domain = rest;
    limited.domain.topRows(12).setConstant(std::numeric_limits<double>::quiet_NaN());
    limited.domain.bottomRows(9).col(2).array() += 0.3;
    const auto variant = [rest](const char* name, const WireOptions& options) {
        return SpaceVariant{name, [=] { return std::make_shared<Wires>(rest, options); }};
    };
    return {.name = "Wires",
            .variants = {variant("smooth", wide), variant("paper", plain), variant("domain", limited)},
            .control = rest,
            .points = shapes::Random(3).points(600, 1.5),
            .translation = {}, // of what is in reach alone
            .follow = 12.0, // the last segment is an eighth of the wire, and turns space within its radius
            .other = [=] { return std::make_shared<Wires>(rest, WireOptions{.counts = {12, 9}}); }};
}

} // namespace

// What they do to points is in tests/bindings/oracles/test_oracles_wires.py.
INSTANTIATE_TEST_SUITE_P(Wires, SpaceContract, testing::Values(traits()));

} // namespace sinew::test_wires
