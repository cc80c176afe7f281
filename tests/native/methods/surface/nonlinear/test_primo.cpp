// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/primo.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_primo {

namespace {

using Fixture = SurfaceFixture<Primo, PrimoOptions>;

SurfaceTraits traits()
{
    SurfaceTraits made =
        Fixture::nonlinear("Primo", {{"default", Fixture::maker(), 2, false}, // a bind has one mean height
                                     {"low", Fixture::maker({.height = {0.005}}), 2, false},
                                     {"high", Fixture::maker({.height = {0.3}}), 2, false}});
    // Bodies get other numbers, so that it stops at another iteration, each within 1 % of how far the
    // surface moves.
    made.similar = 0.1;
    made.iterative = true;
    made.other = Fixture::maker({.height = {0.1}});
    return made;
}

} // namespace

// More of it is in tests/bindings/surfaces/test_nonlinear.py.
INSTANTIATE_TEST_SUITE_P(Primo, SurfaceContract, testing::Values(traits()));

} // namespace sinew::test_primo
