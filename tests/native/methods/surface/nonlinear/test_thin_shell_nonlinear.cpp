// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/thin_shell_nonlinear.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_thin_shell_nonlinear {

namespace {

using Options = ThinShellNonlinearOptions;
using Measure = Options::Measure;
using Fixture = SurfaceFixture<ThinShellNonlinear, Options>;

SurfaceTraits traits()
{
    const Options thick{.measure = Measure::length, .thickness = {2.0}},
        stiff{.measure = Measure::stiffness, .stretching = {2.0}, .bending = {0.5}};
    SurfaceTraits made = Fixture::nonlinear(
        "ThinShellNonlinear", {{"default", Fixture::maker(), 1, false},
                               {"a thick sheet", Fixture::maker(thick), 1, false},
                               {"a sheet without thickness", Fixture::maker({.thickness = {0.0}}), 1, false},
                               {"stiffnesses", Fixture::maker(stiff), 1, false}});
    made.follow = 3.0; // a wall of the bar that buckles snaps, also with a thousand iterations
    made.slack = 0.1;
    made.similar = 0.1; // rounding cuts the squares of the bar along one diagonal or the other
    made.apart = 0.1;
    made.iterative = true;
    made.other = Fixture::maker({.thickness = {0.05}});
    return made;
}

} // namespace

// More of it is in tests/bindings/surfaces/test_nonlinear.py.
INSTANTIATE_TEST_SUITE_P(ThinShellNonlinear, SurfaceContract, testing::Values(traits()));

} // namespace sinew::test_thin_shell_nonlinear
