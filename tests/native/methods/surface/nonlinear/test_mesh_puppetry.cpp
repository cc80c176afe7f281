// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/mesh_puppetry.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_mesh_puppetry {

namespace {

using calls::bend, calls::twist;

class MeshPuppetry : public SurfaceFixture<sinew::MeshPuppetry, MeshPuppetryOptions>
{
public:
    static SurfaceTraits traits()
    {
        SurfaceTraits made = nonlinear(
            "MeshPuppetry", {{"default", maker(), 2, false}, // lambda is scaled by the area of the whole mesh
                             {"without bending", maker({.bending = 0.0}), 2, true},
                             {"stiff", maker({.bending = 0.1, .max_iterations = 20}), 2, false}});
        made.rest = 1e-11; // one linear solve of condition 1e4 for positions of size 12
        made.incoming = 1e-10;
        made.settles = 2000;
        made.other = maker({.bending = 0.01});
        return made;
    }
};

} // namespace

INSTANTIATE_TEST_SUITE_P(MeshPuppetry, SurfaceContract, testing::Values(MeshPuppetry::traits()));

TEST_F(MeshPuppetry, AFewIterationsAreCloseToTheEnd)
{
    const SurfaceMesh mesh = shapes::bar(20, 5);
    const Method few = bound(mesh, {.max_iterations = 5}, shapes::ends(mesh, 2)),
                 all = bound(mesh, {.max_iterations = 2000, .tolerance = 1e-13}, shapes::ends(mesh, 2));
    for (const Poses& poses : {bend(90, 20), twist(135)}) {
        const Solution quick = solve(few, poses), end = solve(all, poses);
        EXPECT_LE(quick.report.iterations + quick.report.rejected, 5);
        // What a few iterations leave on a bar without bones; limbs of a puppet bend at joints alone.
        EXPECT_LT(shapes::distance(quick.positions, end.positions), 0.1 * shapes::size(mesh.points()));
    }
}

} // namespace sinew::test_mesh_puppetry
