// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/handle_aware_isolines.h"

#include "tests/native/methods/surface/fixture.h"

#include <gtest/gtest.h>

namespace sinew::test_handle_aware_isolines {

namespace {

using Fixture = SurfaceFixture<HandleAwareIsolines, HandleAwareIsolinesOptions>;

SurfaceTraits traits()
{
    SurfaceTraits made = Fixture::nonlinear(
        "HandleAwareIsolines", {{"default", Fixture::maker(), 1, true},
                                {"few bands", Fixture::maker({.bands = 5}), 1, true},
                                {"geodesic", Fixture::maker({.field = Field::geodesic}), 1, true}});
    made.rest = 1e-13; // rounding of the fits
    made.rigid = 1e-12; // everything is relative to a rigid motion
    made.held = 1e-13;
    made.similar = 1e-4; // columns are stored in single precision, and turns end at 1e-6
    made.apart = made.folded = 1e-5; // single precision, of columns that are summed up in another order
    made.updates = "bands";
    made.updated = Fixture::maker({.bands = 8});
    return made;
}

} // namespace

INSTANTIATE_TEST_SUITE_P(HandleAwareIsolines, SurfaceContract, testing::Values(traits()));

} // namespace sinew::test_handle_aware_isolines
