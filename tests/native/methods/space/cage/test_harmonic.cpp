// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/harmonic.h"

#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

namespace sinew::test_harmonic {

namespace {

SpaceTraits traits(const std::string& name, HarmonicSolver solver, const SurfaceMesh& cage,
                   const Points& points, double affine)
{
    HarmonicOptions fast;
    fast.weights = cages::doubles;
    fast.quality = HarmonicQuality::fast;
    fast.solver = solver;
    HarmonicOptions medium = fast;
    medium.quality = HarmonicQuality::medium;
    SpaceTraits made = cages::refusing(cages::traits<Harmonic>(name, cage, points, fast, medium));
    made.affine = affine;
    return made;
}

/// The time of a lattice is that of its nodes inside and of the vertices: what is slender has few nodes.
SurfaceMesh slender()
{
    const SurfaceMesh ball = shapes::bumpy_sphere(1, 0.01);
    return shapes::moved(ball, ball.points() * Vector3(1, .4, .4).asDiagonal());
}

} // namespace

// What its weights promise is in tests/bindings/spaces: test_cage_weights.py and test_cages_harmonic.py.
INSTANTIATE_TEST_SUITE_P(Harmonic, SpaceContract,
                         testing::Values(traits("boundary", HarmonicSolver::boundary, shapes::u_prism(),
                                                cages::inside_u_prism(600, 1e-3), 2e-10),
                                         traits("lattice", HarmonicSolver::lattice, slender(),
                                                shapes::points_around(slender(), 200, 0.25), 3e-12)));

} // namespace sinew::test_harmonic
