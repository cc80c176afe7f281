// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/mesh_puppetry.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_mesh_puppetry {

namespace {

using Fixture = SurfaceFixture<MeshPuppetry, MeshPuppetryOptions>;

SurfaceTraits traits()
{
    SurfaceTraits made = Fixture::nonlinear(
        "MeshPuppetry",
        {{"default", Fixture::maker(), 2, false}, // lambda is scaled by the area of the whole mesh
         {"without bending", Fixture::maker({.bending = 0.0}), 2, true},
         {"stiff", Fixture::maker({.bending = 0.1, .max_iterations = 20}), 2, false}});
    made.rest = 1e-11; // one linear solve of condition 1e4 for positions of size 12
    made.incoming = 1e-10;
    made.settles = 2000;
    made.other = Fixture::maker({.bending = 0.01});
    return made;
}

} // namespace

// What a few iterations reach is in tests/bindings/surfaces/test_nonlinear.py.
INSTANTIATE_TEST_SUITE_P(MeshPuppetry, SurfaceContract, testing::Values(traits()));

} // namespace sinew::test_mesh_puppetry
