// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/subdivision_editing.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_subdivision_editing {

namespace {

/// Quads over a hill without symmetry, with noise on every vertex.
SurfaceMesh rough_hill(int columns, int rows)
{
    const SurfaceMesh plain = shapes::quad_grid(columns, rows);
    Points p = plain.points();
    for (int i = 0; i < p.rows(); ++i)
        p(i, 2) = 2 * std::sin(3.0 * p(i, 0) / columns) * std::cos(2.0 * p(i, 1) / rows);
    return shapes::moved(plain, shapes::Random(5).shaken(p, 0.1));
}

using Fixture = SurfaceFixture<SubdivisionEditing, SubdivisionEditingOptions>;

SurfaceTraits traits()
{
    SurfaceTraits made =
        Fixture::linear("SubdivisionEditing", {{"automatic", Fixture::maker({Coarsening::automatic, 1}),
                                                3}, // the level, the control mesh, the band
                                               {"two levels", Fixture::maker({Coarsening::levels, 2}), 4},
                                               {"no level", Fixture::maker({Coarsening::levels, 0}), 1}});
    made.mesh = rough_hill(24, 16);
    made.large = rough_hill(28, 20);
    made.many = rough_hill(96, 64);
    made.bent[1] = shapes::turn({0, 1, 0}, 40, {18, 0, 0}, {-1, 0.5, 2});
    made.many_enter = true;
    made.rest = made.incoming = 1e-13; // each level takes its details apart and puts them together
    made.translation = 1e-9;
    made.rigid = 1e-11; // rounding errors, carried through all levels
    made.similar = 1e-9;
    made.updates = "coarsening";
    made.updated = Fixture::maker({Coarsening::levels, 1});
    return made;
}

} // namespace

// The control meshes that it finds, and its details, are in tests/bindings/surfaces/test_subdivision_editing.py.
INSTANTIATE_TEST_SUITE_P(SubdivisionEditing, SurfaceContract, testing::Values(traits()));

} // namespace sinew::test_subdivision_editing
