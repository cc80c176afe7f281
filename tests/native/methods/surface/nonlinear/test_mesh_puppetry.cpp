// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/mesh_puppetry.h"

#include "native/operators/fits/rotation_fit.h"
#include "native/operators/laplacian.h"
#include "native/skeleton/bone_regions.h"
#include "native/skeleton/pose_solver.h"
#include "tests/native/methods/surface/contract.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <numeric>

namespace sinew::test_mesh_puppetry {

namespace {

struct Solution
{
    Points positions;
    SolveReport report;
};

Solution solve(const SurfaceMethod& method, const Poses& poses, SolveRequest request = {})
{
    Solution solution;
    request.poses = poses;
    solution.report = method.solve(request, solution.positions);
    return solution;
}

/// The end at `along` goes to the end of a circular arc.
Poses bend(double degrees, double along = 12, double depth = 2)
{
    const double angle = degrees * shapes::pi / 180, radius = (along - 2 * depth) / angle;
    const Vector3 end(depth + radius * std::sin(angle), radius * (1 - std::cos(angle)), 0);
    const Vector3 from(along - depth, 0, 0);
    return {shapes::still(), shapes::turn({0, 0, 1}, degrees, from, end - from)};
}

Poses twist(double degrees) { return {shapes::still(), shapes::turn({1, 0, 0}, degrees)}; }

auto maker(const MeshPuppetryOptions& options)
{
    return [options](const SurfaceMesh& mesh) { return std::make_shared<MeshPuppetry>(mesh, options); };
}

SurfaceTraits traits()
{
    const auto drag = [](double s) {
        const double t = 0.5 - 0.5 * std::cos(2 * shapes::pi * s);
        return Poses{shapes::still(), shapes::turn({0.2, 1, 0.5}, 100 * t, {18, 0, 0},
                                                   {-4 * t, 3 * t, 2 * std::sin(2 * shapes::pi * s)})};
    };
    return {.name = "MeshPuppetry",
            .variants = {{"default", maker({}), 2, false}, // lambda is scaled by the area of the whole mesh
                         {"without bending", maker({.bending = 0.0}), 2, true},
                         {"stiff", maker({.bending = 0.1, .max_iterations = 20}), 2, false}},
            .mesh = shapes::bar(12, 3),
            .large = shapes::bar(20, 5),
            .depth = 2,
            .bent = bend(60),
            .drag = drag,
            .drag_steps = 30,
            .follow = 1.5,
            .slack = 0.02,
            .rest = 1e-11, // one linear solve of condition 1e4 for positions of size 12
            .incoming = 1e-10, // edges are taken from what enters: nothing is strained
            .noise = 0.2,
            .translation = 1e-9,
            .rigid = 1e-11,
            .held = 2e-13,
            .alone = 1e-13,
            .similar = 0.01, // rounding differs, and so may the iteration at which it stops
            .scaled = 0.01,
            .apart = 0.05,
            .messy = 30.0,
            .all_soft = 1.0,
            .other = maker({.bending = 0.01})};
}

/// E as in the header, from the positions alone: no code of the rows or of the cells.
double energy_of(const SurfaceMesh& mesh, const Points& q, double bending, const Regions& regions,
                 const Poses& poses)
{
    const SparseMatrix L = laplacian_matrix(mesh, Discretization::cotan);
    const VectorX mass = mass_vector(mesh, Discretization::cotan_voronoi);
    const Points Lp = L * mesh.points(), Lq = L * q;
    const double area = mass.sum();
    double energy = 0.0;
    for (int i = 0; i < mesh.vertex_count(); ++i) {
        Matrix3 S = bending * area / mass[i] * Lq.row(i).transpose() * Lp.row(i);
        double squares = bending * area / mass[i] * (Lq.row(i).squaredNorm() + Lp.row(i).squaredNorm());
        for (SparseMatrix::InnerIterator it(L, i); it; ++it) {
            if (it.row() == i)
                continue;
            const Vector3 to = (q.row(i) - q.row(it.row())).transpose(),
                          from = mesh.point(i) - mesh.point(it.row());
            S += -it.value() * to * from.transpose();
            squares += -it.value() * (to.squaredNorm() + from.squaredNorm());
        }
        const int handle = regions.hard(i);
        const Matrix3 R = handle >= 0 ? Matrix3(poses[handle].leftCols<3>()) : fit_rotation_svd(S);
        energy += 0.5 * (squares - 2 * (R.transpose() * S).trace());
    }
    return energy;
}

} // namespace

INSTANTIATE_TEST_SUITE_P(MeshPuppetry, SurfaceContract, testing::Values(traits()));

TEST(MeshPuppetry, EnergyIsThatOfTheHeader)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    const std::vector<Handle> handles = shapes::ends(mesh, 2);
    const Regions regions(handles, connected_components(mesh));
    for (double bending : {0.0, 1e-3, 0.1}) {
        MeshPuppetry method(mesh, {.bending = bending, .max_iterations = 400, .tolerance = 1e-12});
        method.set_handles(handles);
        for (const Poses& poses : {bend(90), twist(135)}) {
            const Solution solution = solve(method, poses);
            const double energy = energy_of(mesh, solution.positions, bending, regions, poses);
            // The kernels tie a rotation to the last one by 1e-8 of its covariance, whose edges are some 100
            // times as large as what the energy is about.
            EXPECT_NEAR(solution.report.energy, energy, 2e-6 * energy) << bending;
            EXPECT_GT(energy, 0.1);
            // A minimum: no random move of the free vertices lowers it.
            shapes::Random random(3);
            for (int k = 0; k < 20; ++k) {
                Points moved = solution.positions;
                for (int v = 0; v < mesh.vertex_count(); ++v)
                    if (regions.is_free(v))
                        moved.row(v) += 1e-3 * random.vector().transpose();
                EXPECT_GT(energy_of(mesh, moved, bending, regions, poses), energy);
            }
        }
    }
}

TEST(MeshPuppetry, TwoUnrelatedStartsMeet)
{
    const SurfaceMesh mesh = shapes::bar(20, 5);
    MeshPuppetry method(mesh, {.max_iterations = 2000, .tolerance = 1e-13});
    method.set_handles(shapes::ends(mesh, 2));
    shapes::Random random(5);
    for (const Poses& poses : {bend(90, 20), twist(135)}) {
        const Solution own = solve(method, poses);
        Points other = mesh.points();
        for (double& number : other.reshaped())
            number += 0.3 * random.signed_unit();
        const Solution from_rest = solve(method, poses, {.start = view(other)});
        EXPECT_LT(shapes::distance(own.positions, from_rest.positions), 1e-4 * shapes::size(mesh.points()));
    }
}

TEST(MeshPuppetry, AFewIterationsAreCloseToTheEnd)
{
    const SurfaceMesh mesh = shapes::bar(20, 5);
    MeshPuppetry few(mesh, {.max_iterations = 5}), all(mesh, {.max_iterations = 2000, .tolerance = 1e-13});
    few.set_handles(shapes::ends(mesh, 2));
    all.set_handles(shapes::ends(mesh, 2));
    for (const Poses& poses : {bend(90, 20), twist(135)}) {
        const Solution quick = solve(few, poses), end = solve(all, poses);
        EXPECT_LE(quick.report.iterations + quick.report.rejected, 5);
        // What a few iterations leave on a bar without bones; limbs of a puppet bend at joints alone.
        EXPECT_LT(shapes::distance(quick.positions, end.positions), 0.1 * shapes::size(mesh.points()));
    }
}

TEST(MeshPuppetry, SkinFollowsASkeleton)
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
    MeshPuppetry method(mesh);
    method.set_handles(handles);
    Posture posture;
    const Vector3 goal(12, 12, 0); // a right angle
    const PoseReport found = solve_pose(skeleton, {.targets = {{1, skeleton.tail(1), goal}}}, posture);
    EXPECT_LT(found.gaps[0], 0.1);
    const Poses poses = skeleton.poses(posture);
    const Solution solution = solve(method, poses);
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

TEST(MeshPuppetry, RefusesOptionsOutOfRange)
{
    const SurfaceMesh mesh = shapes::cube();
    refusal<InvalidOption>([&] { MeshPuppetry(mesh, {.bending = -1.0}); });
    refusal<InvalidOption>([&] { MeshPuppetry(mesh, {.max_iterations = 0}); });
    refusal<InvalidOption>(
        [&] { MeshPuppetry(mesh, {.tolerance = std::numeric_limits<double>::quiet_NaN()}); });
}

} // namespace sinew::test_mesh_puppetry
