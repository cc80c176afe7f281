// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/harmonic.h"

#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

namespace sinew::test_harmonic {

namespace {

HarmonicOptions exact(HarmonicQuality quality = HarmonicQuality::fast)
{
    HarmonicOptions options;
    options.weights = cages::doubles;
    options.quality = quality;
    return options;
}

SpaceTraits traits()
{
    const SurfaceMesh u = cages::u_prism();
    return {.name = "Harmonic",
            .variants = {cages::variant<Harmonic>("boundary", u, exact())},
            .control = u.points(),
            .points = cages::inside_u_prism(600, 1e-3),
            .affine = 2e-10,
            .outside = Vector3(1.5, 2, 0.5),
            .refuses_outside = true,
            .other = [u] { return std::make_shared<Harmonic>(Cage(u), exact(HarmonicQuality::medium)); }};
}

} // namespace

// What its weights promise is in tests/bindings/spaces/test_cage_weights.py.
INSTANTIATE_TEST_SUITE_P(Harmonic, SpaceContract, testing::Values(traits()));

} // namespace sinew::test_harmonic
