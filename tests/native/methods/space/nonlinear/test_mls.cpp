// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/mls.h"

#include "tests/native/methods/space/contract.h"
#include "tests/native/methods/space/handle_points/fixture.h"

#include <gtest/gtest.h>

namespace sinew::test_mls {

namespace {

using handles::random_points;

constexpr WeightPrecision doubles = WeightPrecision::double_precision;

SpaceTraits traits(MlsMaps kind, const std::string& name)
{
    const Points centres = random_points(25, 1.0, 3);
    const HandlePoints handles{view(centres)};
    const std::vector<std::array<int, 2>> edges{{0, 1}, {2, 3}, {3, 4}};
    SpaceTraits traits{
        .name = name,
        .variants = {{"single", [=] { return std::make_shared<Mls>(handles, MlsOptions{kind}); }},
                     {"double",
                      [=] { return std::make_shared<Mls>(handles, MlsOptions{kind, 2.0, {}, doubles}); }},
                     {"segments",
                      [=] { return std::make_shared<Mls>(handles, MlsOptions{kind, 1.5, edges, doubles}); }}},
        .control = centres,
        .points = random_points(600, 1.3, 4),
        .follow = 8.0, // of affine maps, which may stretch
        .other = [=] { return std::make_shared<Mls>(handles, MlsOptions{kind, 3.0}); }};
    if (kind != MlsMaps::rigid)
        traits.similarity = 1e-11;
    if (kind == MlsMaps::affine)
        traits.affine = 1e-11;
    return traits;
}

} // namespace

// What it does to points is in tests/bindings/oracles/test_oracles_points.py.
INSTANTIATE_TEST_SUITE_P(Mls, SpaceContract,
                         testing::Values(traits(MlsMaps::affine, "affine"),
                                         traits(MlsMaps::similarity, "similarity"),
                                         traits(MlsMaps::rigid, "rigid")));

} // namespace sinew::test_mls
