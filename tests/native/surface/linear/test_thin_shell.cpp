// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/linear/thin_shell.h"

#include "native/core/errors.h"
#include "native/surface/linear/affine_basis.h"
#include "tests/native/allocations.h"
#include "tests/native/shapes.h"
#include "tests/native/surface/linear/dense_shell.h"

#include <gtest/gtest.h>

#include <limits>
#include <thread>

namespace sinew {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::array every{Discretization::uniform, Discretization::cotan, Discretization::cotan_voronoi};

// The systems of 80-vertex meshes have condition numbers of up to 1e4 (order 1) to 1e9 (order 3)
// against an epsilon of 2e-16; the oracle rounds as much again.
constexpr double solved = 1e-6;

ThinShellOptions stiffness(double stretching, double bending, double variation)
{
    return {.stretching = {stretching}, .bending = {bending}, .variation = {variation}};
}

const std::vector<ThinShellOptions> orders{stiffness(1, 0, 0), stiffness(0, 1, 0), stiffness(0, 0, 1),
                                           stiffness(1, 0.5, 0), stiffness(0.3, 1, 2)};

Points solve(const ThinShell& shell, const Poses& poses)
{
    Points positions;
    shell.solve({poses}, positions);
    return positions;
}

Points bound_and_solved(const SurfaceMesh& mesh, const ThinShellOptions& options,
                        const std::vector<Handle>& handles, const Poses& poses)
{
    ThinShell shell(mesh, options);
    shell.set_handles(handles);
    return solve(shell, poses);
}

const Poses bent{shapes::still(), shapes::turn({0, 1, 0}, 40, {6, 0, 0}, {-1, 0.5, 2})};

} // namespace

TEST(ThinShell, rest_in_rest_out)
{
    for (const ThinShellOptions& options : orders)
        for (bool basis : {true, false}) {
            ThinShellOptions chosen = options;
            chosen.affine_basis = basis;
            const SurfaceMesh mesh = shapes::hill(8, 8);
            // Displacements of exactly zero: nothing may move, not by a bit.
            EXPECT_EQ(
                bound_and_solved(mesh, chosen, shapes::ends(mesh, 1.5), {shapes::still(), shapes::still()}),
                mesh.points());
        }
}

TEST(ThinShell, translating_all_handles_translates_everything)
{
    const SurfaceMesh mesh = shapes::hill(9, 7);
    const Vector3 move(3, -2, 5);
    for (const ThinShellOptions& options : orders)
        for (Discretization kind : every) {
            ThinShellOptions chosen = options;
            chosen.laplacian = kind;
            std::vector<Handle> handles = shapes::ends(mesh, 1.5);
            handles[1].weights.assign(handles[1].vertices.size(), 0.4);
            const Poses poses(2, shapes::shift(move.x(), move.y(), move.z()));
            const Points expected = mesh.points().rowwise() + move.transpose();
            EXPECT_LT(shapes::distance(bound_and_solved(mesh, chosen, handles, poses), expected), solved);
        }
}

TEST(ThinShell, any_affine_motion_of_a_framed_plane_is_exact)
{
    // L x = 0 inside a planar mesh, so affine displacements cost nothing where L sees no border:
    // a frame three rings deep hides it from every order.
    const SurfaceMesh plane = shapes::grid(12, 11, 0.5, 0.2);
    const std::vector<Handle> frame{{shapes::where(plane,
                                                   [](const Vector3& p) {
                                                       return p.x() < 1.2 || p.y() < 1.2 || p.x() > 4.8 ||
                                                              p.y() > 4.3;
                                                   }),
                                     {}}};
    Matrix3 A;
    A << 1.2, 0.3, 0, -0.4, 0.8, 0.1, 0.5, 0.2, 2;
    const Pose pose = shapes::affine(A, {1, 2, 3});
    for (const ThinShellOptions& options : orders)
        EXPECT_LT(shapes::distance(bound_and_solved(plane, options, frame, {pose}),
                                   shapes::transformed(plane.points(), pose)),
                  solved);
}

TEST(ThinShell, solves_as_dense_matrices_built_from_angles_do)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    for (const ThinShellOptions& options : orders)
        for (Discretization kind : every)
            for (bool basis : {true, false}) {
                ThinShellOptions chosen = options;
                chosen.laplacian = kind;
                chosen.affine_basis = basis;
                DenseShell oracle(mesh, chosen, handles);
                double energy = 0;
                const Points expected = oracle.solve(bent, &energy);
                ThinShell shell(mesh, chosen);
                shell.set_handles(handles);
                Points positions;
                const SolveReport report = shell.solve({bent}, positions);
                EXPECT_LT(shapes::distance(positions, expected), solved);
                EXPECT_NEAR(report.energy, energy, solved * energy);
                EXPECT_LT(report.residual, 1e-8);
                EXPECT_TRUE(report.converged);
                EXPECT_EQ(report.iterations, 1);
            }
}

TEST(ThinShell, solves_polygons_as_dense_matrices_do)
{
    const SurfaceMesh mesh = shapes::bar(6, 2);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.1);
    for (Discretization kind : every) {
        ThinShellOptions options = stiffness(0.1, 1, 0);
        options.laplacian = kind;
        DenseShell oracle(mesh, options, handles);
        EXPECT_LT(shapes::distance(bound_and_solved(mesh, options, handles, bent), oracle.solve(bent)),
                  solved);
    }
}

TEST(ThinShell, painted_stiffness_scales_its_own_term)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    shapes::Random random(4);
    Stiffness painted(mesh.vertex_count());
    for (double& k : painted)
        k = std::pow(10.0, 2 * random.signed_unit());
    for (int term = 0; term < 3; ++term)
        for (Discretization kind : every) {
            ThinShellOptions options = stiffness(0.2, 0.5, 0.1);
            options.laplacian = kind;
            (term == 0 ? options.stretching : term == 1 ? options.bending : options.variation) = painted;
            DenseShell oracle(mesh, options, handles);
            EXPECT_LT(shapes::distance(bound_and_solved(mesh, options, handles, bent), oracle.solve(bent)),
                      solved)
                << "term " << term;
        }
}

TEST(ThinShell, a_region_painted_black_stays_solvable)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    Stiffness painted(mesh.vertex_count(), 1.0);
    for (int v : shapes::where(mesh, [](const Vector3& p) { return p.y() > 4; }))
        painted[v] = 0.0;
    for (int term = 0; term < 2; ++term) {
        ThinShellOptions options = stiffness(0, 0, 0);
        (term == 0 ? options.stretching : options.bending) = painted;
        DenseShell oracle(mesh, options, handles);
        // A contrast of 1e6 costs six more digits.
        EXPECT_LT(shapes::distance(bound_and_solved(mesh, options, handles, bent), oracle.solve(bent)), 1e-3);
    }
}

TEST(ThinShell, a_painted_constant_is_that_constant)
{
    const SurfaceMesh mesh = shapes::hill(7, 6);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const Points one = bound_and_solved(mesh, stiffness(0.5, 2, 0), handles, bent);
    ThinShellOptions painted;
    painted.stretching.assign(mesh.vertex_count(), 0.5);
    painted.bending.assign(mesh.vertex_count(), 2.0);
    EXPECT_LT(shapes::distance(bound_and_solved(mesh, painted, handles, bent), one), 1e-9);
}

TEST(ThinShell, only_the_ratio_of_the_stiffnesses_counts)
{
    const SurfaceMesh mesh = shapes::hill(7, 6);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const Points one = bound_and_solved(mesh, stiffness(0.3, 1, 0.2), handles, bent);
    for (double scale : {1e-6, 1e6})
        EXPECT_LT(shapes::distance(
                      bound_and_solved(mesh, stiffness(0.3 * scale, scale, 0.2 * scale), handles, bent), one),
                  solved);
}

TEST(ThinShell, is_linear_in_the_poses)
{
    const SurfaceMesh mesh = shapes::hill(8, 7);
    ThinShell shell(mesh);
    shell.set_handles(shapes::ends(mesh, 1.5));
    const Poses a{shapes::shift(1, 2, 3), shapes::still()}, b = bent;
    Poses sum = b;
    sum[0].col(3) += Vector3(1, 2, 3);
    const Points together = solve(shell, a) + solve(shell, b) - mesh.points();
    EXPECT_LT(shapes::distance(solve(shell, sum), together), 1e-9);
}

TEST(ThinShell, turns_with_the_coordinate_system)
{
    // The surface and the poses seen from elsewhere: x' = R x + t.
    const SurfaceMesh mesh = shapes::hill(8, 7);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const Pose view = shapes::turn({1, 2, 3}, 70, {0, 0, 0}, {5, -1, 2});
    const Matrix3 R = view.leftCols<3>();
    Poses seen;
    for (const Pose& pose : bent) {
        const Matrix3 A = R * pose.leftCols<3>() * R.transpose();
        seen.push_back(shapes::affine(A, R * pose.col(3) + view.col(3) - A * view.col(3)));
    }
    const Points elsewhere =
        bound_and_solved(shapes::moved(mesh, shapes::transformed(mesh.points(), view)), {}, handles, seen);
    EXPECT_LT(
        shapes::distance(elsewhere, shapes::transformed(bound_and_solved(mesh, {}, handles, bent), view)),
        solved);
}

TEST(ThinShell, ten_solves_take_one_factorisation)
{
    const SurfaceMesh mesh = shapes::hill(8, 7);
    for (bool basis : {true, false}) {
        ThinShell shell(mesh, {.affine_basis = basis});
        EXPECT_EQ(shell.set_handles(shapes::ends(mesh, 1.5)).factorizations, 1);
        for (int k = 0; k < 10; ++k)
            solve(shell, {shapes::still(), shapes::shift(0, 0, k)});
        EXPECT_EQ(shell.set_handles(shapes::ends(mesh, 2.5)).factorizations, 2);
    }
}

TEST(ThinShell, solves_after_the_first_allocate_nothing_in_proportion_to_the_mesh)
{
    if (!allocations::counted())
        GTEST_SKIP() << "nobody counts here";
    const SurfaceMesh mesh = shapes::hill(60, 60);
    const auto a_number_a_vertex = sizeof(double) * mesh.vertex_count();
    std::vector<Handle> soft = shapes::ends(mesh, 1.5);
    soft[1].weights.assign(soft[1].vertices.size(), 0.5);
    const Poses poses{shapes::still(), shapes::shift(0, 0, 1)};
    for (const bool basis : {true, false})
        for (const std::vector<Handle>& handles : {shapes::ends(mesh, 1.5), soft}) {
            ThinShell shell(mesh, {.affine_basis = basis});
            Points positions;
            const allocations::Count count(a_number_a_vertex);
            shell.set_handles(handles);
            shell.solve({poses}, positions);
            const int first = count.so_far();
            EXPECT_GT(first, 0);
            for (int k = 0; k < 3; ++k)
                shell.solve({poses}, positions);
            EXPECT_EQ(count.so_far(), first);
        }
}

TEST(ThinShell, another_stiffness_gives_what_a_new_object_gives)
{
    const SurfaceMesh mesh = shapes::hill(8, 7);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    ThinShell shell(mesh, stiffness(0.1, 1, 0));
    shell.set_handles(handles);
    solve(shell, bent);
    EXPECT_EQ(shell.set_stiffness({2.0}, {0.5}, {0.0}).factorizations, 2);
    EXPECT_EQ(solve(shell, bent), bound_and_solved(mesh, stiffness(2, 0.5, 0), handles, bent));
}

TEST(ThinShell, solves_from_several_threads_give_the_same_bits)
{
    const SurfaceMesh mesh = shapes::hill(10, 9);
    for (bool basis : {true, false}) {
        ThinShell shell(mesh, {.affine_basis = basis});
        shell.set_handles(shapes::ends(mesh, 1.5));
        const Points alone = solve(shell, bent);
        std::vector<int> wrong(3, 0);
        std::vector<std::thread> threads;
        for (int& count : wrong)
            threads.emplace_back([&] {
                for (int k = 0; k < 20; ++k)
                    count += solve(shell, bent) != alone;
            });
        for (std::thread& thread : threads)
            thread.join();
        EXPECT_EQ(wrong, std::vector<int>(3, 0));
    }
}

TEST(ThinShell, a_dragged_handle_moves_the_surface_without_jumps_and_back_again)
{
    const SurfaceMesh mesh = shapes::hill(10, 9);
    ThinShell shell(mesh);
    shell.set_handles(shapes::ends(mesh, 1.5));
    const int steps = 48;
    const auto at = [&](int k) {
        const double angle = 2 * shapes::pi * k / steps;
        return Poses{shapes::still(), shapes::turn({0, 1, 0}, 60 * std::sin(angle), {9, 4, 0},
                                                   {2 * std::cos(angle) - 2, std::sin(angle), 0})};
    };
    const Points first = solve(shell, at(0));
    Points before = first;
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    for (int k = 1; k <= steps; ++k) {
        const Points now = solve(shell, at(k % steps));
        double handle_step = 0.0;
        for (int v : handles[1].vertices)
            handle_step = std::max(handle_step, (now.row(v) - before.row(v)).norm());
        // A fair surface overshoots its boundary by less than its own size.
        EXPECT_LT(shapes::distance(now, before), 2 * handle_step) << "step " << k;
        before = now;
    }
    EXPECT_EQ(before, first); // the same poses, the same bits
}

TEST(ThinShell, refuses_stiffnesses_that_mean_nothing)
{
    const SurfaceMesh mesh = shapes::cube();
    const auto refused = [&](const Stiffness& s, const Stiffness& b, const Stiffness& v) {
        EXPECT_THROW(ThinShell(mesh, {.stretching = s, .bending = b, .variation = v}), InvalidOption);
        ThinShell shell(mesh);
        shell.set_handles({{{0}, {}}});
        EXPECT_THROW(shell.set_stiffness(s, b, v), InvalidOption);
        EXPECT_EQ(solve(shell, {shapes::still()}), mesh.points());
    };
    for (double bad : {-1.0, nan, std::numeric_limits<double>::infinity()}) {
        refused({bad}, {1.0}, {0.0});
        refused({0.0}, {bad}, {0.0});
        refused({0.0}, {1.0}, {bad});
    }
    refused({0.0}, {0.0}, {0.0});
    refused({0.0}, {1.0, 1.0}, {0.0});
    refused({}, {1.0}, {0.0});
    refused({0.0}, Stiffness(8, 0.0), {0.0});
    try {
        Stiffness painted(8, 1.0);
        painted[3] = painted[5] = -1;
        ThinShell(mesh, {.bending = painted});
        FAIL();
    } catch (const InvalidOption& error) {
        EXPECT_EQ(error.elements(), (std::vector{3, 5}));
        EXPECT_EQ(error.element_kind(), Error::Element::vertex);
    }
}

TEST(ThinShell, refuses_poses_that_do_not_fit)
{
    const SurfaceMesh mesh = shapes::hill(6, 6);
    ThinShell shell(mesh);
    shell.set_handles(shapes::ends(mesh, 1.5));
    Points out;
    EXPECT_THROW(shell.solve({{shapes::still()}}, out), InvalidConstraint);
    EXPECT_THROW(shell.solve({Poses(3, shapes::still())}, out), InvalidConstraint);
    Poses bad(2, shapes::still());
    bad[1](0, 0) = nan;
    EXPECT_THROW(shell.solve({bad}, out), InvalidConstraint);
    const Points other = Points::Zero(3, 3);
    EXPECT_THROW(shell.solve({bent, view(other)}, out), InvalidConstraint);
    Points broken = mesh.points();
    broken(4, 1) = nan;
    EXPECT_THROW(shell.solve({bent, view(broken)}, out), InvalidConstraint);
    const std::vector<bool> flags(3, true);
    EXPECT_THROW(shell.solve({.poses = bent, .from_rest = flags}, out), InvalidConstraint);
}

} // namespace sinew
