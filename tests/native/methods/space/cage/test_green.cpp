// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/green.h"

#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

namespace sinew::test_green {

namespace {

SpaceTraits traits(const std::string& name, const SurfaceMesh& cage, const Points& points,
                   GreenFaces faces = GreenFaces::triangles, GreenOutside outside = GreenOutside::nearest)
{
    const GreenOptions other{cages::doubles, GreenOutside::face, 1};
    SpaceTraits made = cages::traits<Green>(name, cage, points, {cages::doubles, outside, -1, faces}, other);
    made.similarity = 1e-11;
    made.follow = 3.0; // normals turn with the faces at the vertex
    return made;
}

/// Quads none of which is flat.
SurfaceMesh crooked_bar()
{
    const SurfaceMesh bar = shapes::bar(3, 2);
    return shapes::moved(bar, shapes::Random(12).shaken(bar.points(), 0.2));
}

const SurfaceMesh u = shapes::u_prism(), quads = crooked_bar(); // of the U, the ends are no quads

} // namespace

// What its weights promise is in tests/bindings/spaces/test_cage_weights.py.
INSTANTIATE_TEST_SUITE_P(
    Green, SpaceContract,
    testing::Values(traits("nearest", u, shapes::points_around(u, 600, 1.0)),
                    cages::refusing(traits("refusing", u, cages::inside_u_prism(600, 1e-3),
                                           GreenFaces::triangles, GreenOutside::refuse)),
                    traits("quads", quads, shapes::points_around(quads, 600, 1.0), GreenFaces::quads),
                    cages::refusing(traits("both", u, cages::inside_u_prism(600, 1e-3), GreenFaces::quads,
                                           GreenOutside::refuse))));

} // namespace sinew::test_green
