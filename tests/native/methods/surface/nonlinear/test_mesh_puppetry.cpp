// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/mesh_puppetry.h"

#include "native/skeleton/bone_regions.h"
#include "native/skeleton/pose_solver.h"
#include "tests/native/methods/surface/fixture.h"
#include "tests/native/refusals.h"
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

TEST_F(MeshPuppetry, SkinFollowsASkeleton)
{
    // A bar along x with two bones: it bends where these meet, and the limbs stay as they are.
    const SurfaceMesh mesh = shapes::bar(24, 3);
    Points heads(2, 3), tails(2, 3);
    heads << 0, 0, 0, 12, 0, 0;
    tails << 12, 0, 0, 24, 0, 0;
    const Skeleton skeleton(heads, tails, {-1, 0});
    const std::vector<std::vector<int>> regions = bone_regions(mesh, skeleton);
    ASSERT_EQ(regions.size(), 2u);
    std::vector<Handle> handles;
    for (const std::vector<int>& vertices : regions) {
        EXPECT_GT(vertices.size(), 50u);
        handles.push_back({vertices, {}, 2.0});
    }
    Posture posture;
    const Vector3 goal(12, 12, 0); // a right angle
    const PoseReport found = solve_pose(skeleton, {.targets = {{1, skeleton.tail(1), goal}}}, posture);
    EXPECT_LT(found.gaps[0], 0.1);
    const Poses poses = skeleton.poses(posture);
    const Solution solution = solve(bound(mesh, {}, handles), poses);
    for (std::size_t b = 0; b < regions.size(); ++b)
        for (int v : regions[b])
            EXPECT_LT((solution.positions.row(v).transpose() - apply(poses[b], mesh.point(v))).norm(), 1e-12);
    // The skin at the joint bends: edges of its inner side get shorter, as of any bar, and none folds.
    for (const auto& [a, b] : mesh.edges()) {
        const double before = (mesh.point(a) - mesh.point(b)).norm(),
                     after = (solution.positions.row(a) - solution.positions.row(b)).norm();
        EXPECT_LT(after, 1.6 * before);
        EXPECT_GT(after, 0.3 * before);
    }
}

TEST_F(MeshPuppetry, RefusesOptionsOutOfRange)
{
    expect_refused(shapes::cube(), {{.bending = -1.0}, {.max_iterations = 0}, {.tolerance = nan}});
}

} // namespace sinew::test_mesh_puppetry
