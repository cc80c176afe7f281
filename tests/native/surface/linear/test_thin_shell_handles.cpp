// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/errors.h"
#include "native/surface/linear/thin_shell.h"
#include "tests/native/shapes.h"
#include "tests/native/surface/linear/dense_shell.h"

#include <gtest/gtest.h>

// Soft and hard handles, incoming poses.

namespace sinew {

namespace {

constexpr std::array every{Discretization::uniform, Discretization::cotan, Discretization::cotan_voronoi};

Points solve(const ThinShell& shell, const Poses& poses, std::optional<PointsView> incoming = {})
{
    Points positions;
    shell.solve({.poses = poses, .incoming = incoming}, positions);
    return positions;
}

const Poses bent{shapes::still(), shapes::turn({0, 1, 0}, 40, {6, 0, 0}, {-1, 0.5, 2})};

std::vector<Handle> softened(std::vector<Handle> handles, double weight)
{
    handles[1].weights.assign(handles[1].vertices.size(), weight);
    return handles;
}

} // namespace

TEST(ThinShellHandles, soft_ones_pull_as_the_dense_system_says)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    shapes::Random random(2);
    std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    for (std::size_t k = 0; k < handles[1].vertices.size(); ++k)
        handles[1].weights.push_back(k % 5 == 0 ? 1.0 : k % 5 == 1 ? 0.0 : random.unit());
    handles.push_back({{40, 41, 42, handles[1].vertices[2]}, {0.5, 0.9, 0.1, 0.3}});
    const Poses poses{bent[0], bent[1], shapes::shift(0, 0, 3)};
    for (Discretization kind : every)
        for (bool basis : {true, false}) {
            const ThinShellOptions options{.stretching = {0.2}, .laplacian = kind, .affine_basis = basis};
            DenseShell oracle(mesh, options, handles);
            double energy = 0;
            const Points expected = oracle.solve(poses, &energy);
            ThinShell shell(mesh, options);
            shell.set_handles(handles);
            Points positions;
            const SolveReport report = shell.solve({poses}, positions);
            EXPECT_LT(shapes::distance(positions, expected), 1e-8); // condition about 1e5
            EXPECT_NEAR(report.energy, energy, 1e-8 * energy);
        }
}

TEST(ThinShellHandles, soft_ones_become_hard_as_their_weight_nears_one)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    ThinShell shell(mesh);
    shell.set_handles(shapes::ends(mesh, 1.5));
    const Points hard = solve(shell, bent);
    double before = 1.0;
    for (double gap : {1e-2, 1e-4, 1e-6, 1e-8}) {
        shell.set_handles(softened(shapes::ends(mesh, 1.5), 1 - gap));
        const double error = shapes::distance(solve(shell, bent), hard);
        EXPECT_LT(error, 0.05 * before) << gap; // the error falls as 1 - w, a factor of 100 each
        before = error;
    }
    EXPECT_LT(before, 1e-5);
}

TEST(ThinShellHandles, a_weight_a_hair_below_one_still_solves)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    ThinShell shell(mesh);
    shell.set_handles(shapes::ends(mesh, 1.5));
    const Points hard = solve(shell, bent);
    for (double gap : {1e-10, 1e-12, 1e-15}) {
        shell.set_handles(softened(shapes::ends(mesh, 1.5), 1 - gap));
        EXPECT_LT(shapes::distance(solve(shell, bent), hard), 1e-4) << gap;
    }
}

TEST(ThinShellHandles, soft_ones_let_go_as_their_weight_nears_zero)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    ThinShell shell(mesh);
    shell.set_handles(softened(shapes::ends(mesh, 1.5), 1e-12));
    // One hard handle at rest against pulls of 1e-12: moves of some 1e-12 x the softest mode.
    EXPECT_LT(shapes::distance(solve(shell, bent), mesh.points()), 1e-6);
}

TEST(ThinShellHandles, hard_ones_are_met_to_the_bit_without_the_basis)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    ThinShell shell(mesh, {.affine_basis = false});
    shell.set_handles(shapes::ends(mesh, 1.5));
    const Points positions = solve(shell, bent);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    for (int h : {0, 1})
        for (int v : handles[h].vertices)
            EXPECT_LT((positions.row(v).transpose() - apply(bent[h], mesh.point(v))).norm(), 1e-14);
}

TEST(ThinShellHandles, displacements_are_added_to_the_incoming_pose)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    for (bool basis : {true, false}) {
        ThinShell shell(mesh, {.affine_basis = basis});
        shell.set_handles(shapes::ends(mesh, 1.5));
        const Points incoming = shapes::transformed(mesh.points(), shapes::turn({1, 2, 0}, 30));
        // A translated handle displaces the incoming surface as it displaces the rest.
        const Poses lifted{shapes::still(), shapes::shift(0, 0, 2)};
        EXPECT_LT(shapes::distance(solve(shell, lifted, view(incoming)) - incoming,
                                   solve(shell, lifted) - mesh.points()),
                  1e-10);
        // The rest as incoming pose is no incoming pose.
        EXPECT_LT(shapes::distance(solve(shell, bent, view(mesh.points())), solve(shell, bent)), 1e-10);
    }
}

} // namespace sinew
