// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/errors.h"
#include "native/surface/linear/thin_shell.h"
#include "tests/native/shapes.h"
#include "tests/native/surface/linear/dense_shell.h"

#include <gtest/gtest.h>

#include <limits>

// Soft and hard handles, parts without any, incoming poses, bad meshes, failed and cancelled binds.

namespace sinew {

namespace {

constexpr std::array every{Discretization::uniform, Discretization::cotan, Discretization::cotan_voronoi};

Points solve(const ThinShell& shell, const Poses& poses, std::optional<PointsView> incoming = {},
             const std::optional<std::vector<bool>>& from_rest = {})
{
    Points positions;
    shell.solve({.poses = poses, .incoming = incoming, .from_rest = from_rest}, positions);
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

TEST(ThinShellHandles, a_single_vertex_can_be_a_handle)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    handles[1].vertices = {40};
    ThinShell shell(mesh);
    shell.set_handles(handles);
    const Points positions = solve(shell, {shapes::still(), shapes::shift(0, 0, 2)});
    EXPECT_NEAR(positions(40, 2), mesh.points()(40, 2) + 2, 1e-12);
    EXPECT_TRUE(positions.allFinite());
}

TEST(ThinShellHandles, before_any_the_shape_that_comes_in_goes_out)
{
    const SurfaceMesh mesh = shapes::hill(4, 4);
    const ThinShell shell(mesh);
    EXPECT_EQ(solve(shell, {}), mesh.points());
    const Points incoming = 2 * mesh.points();
    EXPECT_EQ(solve(shell, {}, view(incoming)), incoming);
}

TEST(ThinShellHandles, none_leave_every_part_at_rest)
{
    const SurfaceMesh mesh = shapes::hill(4, 4);
    ThinShell shell(mesh);
    const BindReport report = shell.set_handles({});
    EXPECT_EQ(report.free_parts, 1);
    EXPECT_EQ(solve(shell, {}), mesh.points());
}

TEST(ThinShellHandles, may_hold_every_vertex)
{
    const SurfaceMesh mesh = shapes::hill(4, 4);
    for (bool basis : {true, false}) {
        ThinShell shell(mesh, {.affine_basis = basis});
        shell.set_handles({{shapes::where(mesh, [](const Vector3&) { return true; }), {}}});
        EXPECT_LT(shapes::distance(solve(shell, {bent[1]}), shapes::transformed(mesh.points(), bent[1])),
                  1e-13);
    }
}

TEST(ThinShellHandles, a_part_without_one_stays_at_rest_and_is_counted)
{
    const SurfaceMesh first = shapes::hill(6, 6);
    const SurfaceMesh mesh = shapes::joined(first, shapes::sphere(1), {20, 0, 0});
    ThinShell shell(mesh);
    const std::vector<Handle> handles{{shapes::ends(first, 1.5)[0]}, {shapes::ends(first, 1.5)[1]}};
    const BindReport report = shell.set_handles(handles);
    EXPECT_EQ(report.free_parts, 1);
    ASSERT_EQ(report.free_vertices.size(), 18u);
    EXPECT_EQ(report.free_vertices.front(), first.vertex_count());
    const Points positions = solve(shell, bent);
    EXPECT_EQ(positions.bottomRows(18), mesh.points().bottomRows(18));

    ThinShell alone(first);
    alone.set_handles(handles);
    EXPECT_LT(shapes::distance(positions.topRows(first.vertex_count()), solve(alone, bent)), 1e-9);

    Points incoming = mesh.points();
    incoming.bottomRows(18).rowwise() += Eigen::RowVector3d(0, 0, 9);
    EXPECT_EQ(solve(shell, bent, view(incoming)).bottomRows(18), incoming.bottomRows(18));
}

TEST(ThinShellHandles, an_incoming_pose_passes_through_where_no_handle_moves)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    ThinShell shell(mesh);
    shell.set_handles(shapes::ends(mesh, 1.5));
    Points incoming = mesh.points();
    shapes::Random random(3);
    for (int i = 0; i < incoming.rows(); ++i)
        incoming.row(i) += random.vector().transpose();
    EXPECT_EQ(solve(shell, {shapes::still(), shapes::still()}, view(incoming)), incoming);
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

TEST(ThinShellHandles, one_that_aims_from_rest_ignores_the_incoming_pose)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    ThinShell shell(mesh);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    shell.set_handles(handles);
    const Points incoming = mesh.points().rowwise() + Eigen::RowVector3d(0, 5, 0);
    const std::vector<bool> from_rest{false, true};
    const Points positions = solve(shell, bent, view(incoming), from_rest);
    for (int h : {0, 1})
        for (int v : handles[h].vertices) {
            const Vector3 from = h == 1 ? mesh.point(v) : Vector3(incoming.row(v).transpose());
            EXPECT_LT((positions.row(v).transpose() - apply(bent[h], from)).norm(), 1e-13);
        }
}

TEST(ThinShellHandles, a_refused_or_cancelled_bind_leaves_everything_as_it_was)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    for (bool basis : {true, false}) {
        ThinShell shell(mesh, {.affine_basis = basis});
        shell.set_handles(shapes::ends(mesh, 1.5));
        const Points before = solve(shell, bent);
        EXPECT_THROW(shell.set_handles({{{}, {}}}), InvalidConstraint);
        EXPECT_THROW(shell.set_handles({{{0}, {}}, {{0}, {}}}), InvalidConstraint);
        EXPECT_EQ(solve(shell, bent), before);

        const std::vector<Handle> others = shapes::ends(mesh, 3.5);
        int cancelled = 0;
        for (int stop = 1;; ++stop) {
            int ticks = 0;
            try {
                shell.set_handles(others, Progress([&](double, const char*) { return ++ticks < stop; }));
                break;
            } catch (const Cancelled&) {
                ++cancelled;
                EXPECT_EQ(solve(shell, bent), before) << "cancelled at tick " << stop;
            }
        }
        EXPECT_GE(cancelled, 3); // assembling, factorising, bound
        ThinShell fresh(mesh, {.affine_basis = basis});
        fresh.set_handles(others);
        EXPECT_EQ(solve(shell, bent), solve(fresh, bent));
    }
}

TEST(ThinShellHandles, progress_rises_to_one)
{
    const SurfaceMesh mesh = shapes::hill(6, 6);
    ThinShell shell(mesh);
    double last = 0.0;
    shell.set_handles(shapes::ends(mesh, 1.5), Progress([&](double fraction, const char* stage) {
                          EXPECT_GE(fraction, last);
                          EXPECT_LE(fraction, 1.0);
                          EXPECT_STRNE(stage, "");
                          last = fraction;
                          return true;
                      }));
    EXPECT_EQ(last, 1.0);
}

TEST(ThinShellHandles, bind_and_solve_on_messy_meshes)
{
    const SurfaceMesh mesh = shapes::messy();
    for (Discretization kind : every)
        for (const auto& [s, b, v] :
             {std::array{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, {1.0, 1.0, 1.0}}) {
            ThinShell shell(mesh, {.stretching = {s}, .bending = {b}, .variation = {v}, .laplacian = kind});
            const std::vector<Handle> handles{{{0, 1, 9, 10}, {}}, {{79, 80, 70, 71}, {}}};
            const BindReport report = shell.set_handles(handles);
            EXPECT_EQ(report.free_parts, 2); // the triangle of its own, the loose vertex
            EXPECT_EQ(report.degenerate_faces, 3);
            const Points positions = solve(shell, {shapes::still(), shapes::shift(1, 2, 3)});
            EXPECT_TRUE(positions.allFinite());
            // Fair surfaces overshoot by little: nothing may fly off.
            EXPECT_LT(shapes::distance(positions, mesh.points()), 20.0);
        }
}

TEST(ThinShellHandles, meshes_without_any_area_still_solve)
{
    for (double line : {0.0, 1.0}) {
        Points p = Points::Zero(25, 3);
        p.col(0) = line * shapes::grid_points(4, 4).col(0);
        const SurfaceMesh mesh = shapes::moved(shapes::grid(4, 4), p);
        for (Discretization kind : every) {
            ThinShell shell(mesh, {.laplacian = kind});
            try {
                shell.set_handles({{{0, 1, 2, 5, 6}, {}}, {{24}, {}}});
                EXPECT_TRUE(solve(shell, {shapes::still(), shapes::shift(0, 0, 1)}).allFinite());
            } catch (const FactorizationFailed&) {
                // A point has no metric: a typed refusal is an answer.
            }
        }
    }
}

TEST(ThinShellHandles, does_not_mind_the_size_of_the_mesh)
{
    const SurfaceMesh unit = shapes::hill(8, 8);
    const std::vector<Handle> handles = shapes::ends(unit, 1.5);
    ThinShell shell(unit);
    shell.set_handles(handles);
    const Points expected = solve(shell, bent);
    for (double scale : {1e-12, 1e-6, 1e6, 1e12}) {
        ThinShell scaled(shapes::moved(unit, scale * unit.points()));
        scaled.set_handles(handles);
        Poses poses = bent;
        for (Pose& pose : poses)
            pose.col(3) *= scale;
        EXPECT_LT(shapes::distance(solve(scaled, poses) / scale, expected), 1e-7) << scale;
    }
}

} // namespace sinew
