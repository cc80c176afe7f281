// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/errors.h"
#include "native/surface/nonlinear/arap.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

// Soft and hard handles, parts without any, incoming poses, bad meshes, cancelled calls.

namespace sinew {

namespace {

Points solve(const Arap& arap, const Poses& poses, SolveRequest request = {})
{
    Points positions;
    request.poses = poses;
    arap.solve(request, positions);
    return positions;
}

const Poses bent{shapes::still(), shapes::turn({0, 0, 1}, 60, {10, 0, 0}, {-2, 4, 0})};

double worst_gap(const SurfaceMesh& mesh, const Points& q, const std::vector<int>& vertices, const Pose& pose)
{
    double gap = 0.0;
    for (int v : vertices)
        gap = std::max(gap, (q.row(v).transpose() - apply(pose, mesh.point(v))).norm());
    return gap;
}

} // namespace

TEST(ArapHandles, hard_ones_are_met_to_rounding)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    for (double smoothness : {0.0, 5e-4}) {
        Arap arap(mesh, {.smoothness = smoothness});
        const std::vector<Handle> handles = shapes::ends(mesh, 2);
        arap.set_handles(handles);
        const Points q = solve(arap, bent);
        for (int h : {0, 1})
            EXPECT_LT(worst_gap(mesh, q, handles[h].vertices, bent[h]), 1e-14 * 20);
    }
}

TEST(ArapHandles, soft_ones_are_met_the_better_the_nearer_their_weight_is_to_one)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    std::vector<Handle> handles = shapes::ends(mesh, 2);
    Arap arap(mesh);
    double before = 1e9;
    for (double weight : {0.01, 0.2, 0.9, 0.999, 0.999999}) {
        handles[1].weights.assign(handles[1].vertices.size(), weight);
        const BindReport report = arap.set_handles(handles);
        EXPECT_EQ(report.soft_vertices, static_cast<int>(handles[1].vertices.size()));
        const double gap =
            worst_gap(mesh, solve(arap, bent, {.max_iterations = 100}), handles[1].vertices, bent[1]);
        EXPECT_LT(gap, before);
        before = gap;
    }
    EXPECT_LT(before, 1e-4); // pulls of 1e6 times the vertex's own stiffness against strains of some tenths
}

TEST(ArapHandles, may_all_be_soft)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    std::vector<Handle> handles = shapes::ends(mesh, 2);
    for (Handle& handle : handles)
        handle.weights.assign(handle.vertices.size(), 0.7);
    for (double smoothness : {0.0, 5e-4}) {
        Arap arap(mesh, {.smoothness = smoothness});
        arap.set_handles(handles);
        const Points q = solve(arap, bent);
        EXPECT_TRUE(q.allFinite());
        EXPECT_LT(worst_gap(mesh, q, handles[1].vertices, bent[1]), 1.0);
    }
}

TEST(ArapHandles, a_soft_bind_still_never_raises_the_energy)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    std::vector<Handle> handles = shapes::ends(mesh, 2);
    handles[1].weights.assign(handles[1].vertices.size(), 0.9);
    for (auto cells : {ArapOptions::Cells::spokes, ArapOptions::Cells::rims}) {
        Arap arap(mesh, {.cells = cells});
        arap.set_handles(handles);
        double before = std::numeric_limits<double>::infinity();
        for (int k = 0; k <= 12; ++k) {
            Points q;
            const SolveReport report = arap.solve({.poses = bent, .max_iterations = k, .tolerance = 0.0}, q);
            EXPECT_LE(report.energy, before * (1 + 1e-12));
            before = report.energy;
        }
    }
}

TEST(ArapHandles, a_single_vertex_can_be_a_handle)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    std::vector<Handle> handles = shapes::ends(mesh, 2);
    handles[1].vertices.resize(1);
    Arap arap(mesh);
    arap.set_handles(handles);
    const Points q = solve(arap, {shapes::still(), shapes::shift(0, 3, 0)});
    EXPECT_TRUE(q.allFinite());
    EXPECT_LT(worst_gap(mesh, q, handles[1].vertices, shapes::shift(0, 3, 0)), 1e-13);
    // One vertex alone: the whole part follows as a rigid body.
    arap.set_handles({{{0}, {}}});
    EXPECT_LT(shapes::distance(solve(arap, {shapes::shift(1, 2, 3)}),
                               shapes::transformed(mesh.points(), shapes::shift(1, 2, 3))),
              1e-9);
}

TEST(ArapHandles, before_any_the_shape_that_comes_in_goes_out)
{
    const SurfaceMesh mesh = shapes::bar(4, 2);
    Arap arap(mesh);
    EXPECT_EQ(solve(arap, {}), mesh.points());
    const Points incoming = 2 * mesh.points();
    EXPECT_EQ(solve(arap, {}, {.incoming = view(incoming)}), incoming);
    EXPECT_EQ(arap.set_handles({}).free_parts, 1);
    EXPECT_EQ(solve(arap, {}, {.incoming = view(incoming)}), incoming);
}

TEST(ArapHandles, may_hold_every_vertex)
{
    const SurfaceMesh mesh = shapes::bar(4, 2);
    Arap arap(mesh);
    arap.set_handles({{shapes::where(mesh, [](const Vector3&) { return true; }), {}}});
    EXPECT_LT(shapes::distance(solve(arap, {bent[1]}), shapes::transformed(mesh.points(), bent[1])), 1e-13);
}

TEST(ArapHandles, a_part_without_one_stays_and_the_others_do_not_feel_it)
{
    const SurfaceMesh first = shapes::bar(12, 3);
    const SurfaceMesh mesh = shapes::joined(first, shapes::sphere(2), {0, 20, 0});
    for (double smoothness : {0.0, 5e-4}) {
        Arap arap(mesh, {.smoothness = smoothness});
        const BindReport report = arap.set_handles(shapes::ends(first, 2));
        EXPECT_EQ(report.free_parts, 1);
        EXPECT_EQ(report.free_vertices.size(), 66u);
        const Points q = solve(arap, bent);
        EXPECT_EQ(q.bottomRows(66), mesh.points().bottomRows(66));
        Points incoming = mesh.points();
        incoming.bottomRows(66).rowwise() += Eigen::RowVector3d(0, 0, 9);
        EXPECT_EQ(solve(arap, bent, {.incoming = view(incoming)}).bottomRows(66), incoming.bottomRows(66));
        if (smoothness > 0)
            continue; // alpha is scaled by the area of the whole mesh
        Arap alone(first, {.smoothness = 0});
        alone.set_handles(shapes::ends(first, 2));
        EXPECT_LT(shapes::distance(q.topRows(first.vertex_count()), solve(alone, bent)), 0.05);
    }
}

TEST(ArapHandles, each_part_follows_its_own)
{
    const SurfaceMesh first = shapes::bar(12, 3);
    const SurfaceMesh mesh = shapes::joined(first, first, {0, 20, 0});
    std::vector<Handle> handles = shapes::ends(first, 2);
    handles.push_back({{first.vertex_count() + 3, first.vertex_count() + 40, first.vertex_count() + 80}, {}});
    const Pose pose = shapes::turn({0, 0, 1}, 100, {0, 20, 0});
    Arap arap(mesh);
    arap.set_handles(handles);
    const Points q = solve(arap, {bent[0], bent[1], pose});
    // The second part has one handle: it moves as a rigid body. Its start blends rotations of
    // its own handle alone.
    const Points expected = shapes::transformed(mesh.points().bottomRows(first.vertex_count()), pose);
    EXPECT_LT(shapes::distance(q.bottomRows(first.vertex_count()), expected), 1e-6);
}

TEST(ArapHandles, an_incoming_pose_passes_through_where_no_handle_moves)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    for (double smoothness : {0.0, 5e-4}) {
        Arap arap(mesh, {.smoothness = smoothness});
        arap.set_handles(shapes::ends(mesh, 2));
        Points incoming = mesh.points();
        shapes::Random random(3);
        for (int i = 0; i < incoming.rows(); ++i)
            incoming.row(i) += 0.2 * random.vector().transpose();
        // Edges are taken from the incoming pose: nothing is strained, the answer is exact.
        EXPECT_LT(
            shapes::distance(solve(arap, Poses(2, shapes::still()), {.incoming = view(incoming)}), incoming),
            1e-11);
        // And so is a rigid motion of it.
        const Pose pose = shapes::turn({1, 1, 0}, 150, {0, 3, 0}, {1, 2, 3});
        EXPECT_LT(shapes::distance(solve(arap, {pose, pose}, {.incoming = view(incoming)}),
                                   shapes::transformed(incoming, pose)),
                  1e-10);
    }
}

TEST(ArapHandles, one_that_aims_from_rest_ignores_the_incoming_pose)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    Arap arap(mesh);
    const std::vector<Handle> handles = shapes::ends(mesh, 2);
    arap.set_handles(handles);
    const Points incoming = mesh.points().rowwise() + Eigen::RowVector3d(0, 0, 5);
    const std::vector<bool> flags{false, true};
    const Points q = solve(arap, bent, {.incoming = view(incoming), .from_rest = flags});
    EXPECT_LT(worst_gap(mesh, q, handles[1].vertices, bent[1]), 1e-13);
    EXPECT_LT(worst_gap(mesh, q, handles[0].vertices, shapes::shift(0, 0, 5)), 1e-13);
}

TEST(ArapHandles, bind_and_solve_on_messy_meshes)
{
    const SurfaceMesh mesh = shapes::messy();
    for (double smoothness : {0.0, 5e-4})
        for (auto cells : {ArapOptions::Cells::spokes, ArapOptions::Cells::rims}) {
            Arap arap(mesh, {.smoothness = smoothness, .cells = cells});
            const BindReport report = arap.set_handles({{{0, 1, 9, 10}, {}}, {{79, 80, 70, 71}, {}}});
            EXPECT_EQ(report.free_parts, 2);
            EXPECT_EQ(report.degenerate_faces, 3);
            double before = std::numeric_limits<double>::infinity();
            for (int k : {0, 1, 2, 4, 8, 40}) {
                Points q;
                const SolveReport solved =
                    arap.solve({.poses = {shapes::still(), shapes::turn({0, 0, 1}, 40, {8, 8, 0}, {1, 2, 3})},
                                .max_iterations = k,
                                .tolerance = 0.0},
                               q);
                EXPECT_TRUE(q.allFinite());
                EXPECT_LT(shapes::distance(q, mesh.points()), 30.0); // nothing flies off
                EXPECT_LE(solved.energy, before * (1 + 1e-12));
                before = solved.energy;
            }
        }
}

TEST(ArapHandles, faces_of_one_corner_repeated_change_nothing)
{
    const SurfaceMesh clean = shapes::hill(6, 6);
    shapes::Polygons faces = shapes::faces_of(clean);
    for (int v : {0, 20, 48})
        faces.push_back({v, v, v});
    const SurfaceMesh folded = shapes::over(clean.points(), faces);
    for (double smoothness : {0.0, 5e-4})
        for (auto cells : {ArapOptions::Cells::spokes, ArapOptions::Cells::rims}) {
            Arap plain(clean, {.smoothness = smoothness, .cells = cells});
            Arap odd(folded, {.smoothness = smoothness, .cells = cells});
            plain.set_handles(shapes::ends(clean, 1.5));
            odd.set_handles(shapes::ends(clean, 1.5));
            const Poses lifted{shapes::still(), shapes::turn({0, 1, 0}, 40, {6, 0, 0}, {0, 0, 2})};
            EXPECT_LT(shapes::distance(solve(odd, lifted), solve(plain, lifted)),
                      1e-9); // the same sums, other order
        }
}

TEST(ArapHandles, meshes_without_any_area_still_solve)
{
    for (double line : {0.0, 1.0}) {
        Points p = Points::Zero(25, 3);
        p.col(0) = line * shapes::grid_points(4, 4).col(0);
        const SurfaceMesh mesh = shapes::moved(shapes::grid(4, 4), p);
        for (double smoothness : {0.0, 5e-4}) {
            Arap arap(mesh, {.smoothness = smoothness});
            try {
                arap.set_handles({{{0, 1, 2, 5, 6}, {}}, {{24}, {}}});
                EXPECT_TRUE(solve(arap, {shapes::still(), shapes::shift(0, 0, 1)}).allFinite());
            } catch (const FactorizationFailed&) {
                // A point has no metric: a typed refusal is an answer.
            }
        }
    }
}

TEST(ArapHandles, a_region_painted_black_stays_solvable)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    ArapOptions options;
    options.rigidity.assign(mesh.vertex_count(), 1.0);
    for (int v : shapes::where(mesh, [](const Vector3& p) { return p.x() > 4 && p.x() < 8; }))
        options.rigidity[v] = 0.0;
    Arap arap(mesh, options);
    arap.set_handles(shapes::ends(mesh, 2));
    EXPECT_TRUE(solve(arap, bent).allFinite());
}

TEST(ArapHandles, a_refused_or_cancelled_bind_leaves_everything_as_it_was)
{
    const SurfaceMesh mesh = shapes::bar(20, 5);
    Arap arap(mesh);
    arap.set_handles(shapes::ends(mesh, 2));
    const Points before = solve(arap, bent);
    EXPECT_THROW(arap.set_handles({{{}, {}}}), InvalidConstraint);
    EXPECT_THROW(arap.set_handles({{{0}, {}}, {{0}, {}}}), InvalidConstraint);
    EXPECT_EQ(solve(arap, bent), before);
    const std::vector<Handle> others = shapes::ends(mesh, 4);
    int cancelled = 0;
    for (int stop = 1;; ++stop) {
        int ticks = 0;
        try {
            arap.set_handles(others, Progress([&](double, const char*) { return ++ticks < stop; }));
            break;
        } catch (const Cancelled&) {
            ++cancelled;
            EXPECT_EQ(solve(arap, bent), before) << "cancelled at tick " << stop;
        }
    }
    EXPECT_GE(cancelled, 3);
    Arap fresh(mesh);
    fresh.set_handles(others);
    EXPECT_EQ(solve(arap, bent), solve(fresh, bent));
}

TEST(ArapHandles, a_cancelled_solve_leaves_the_object_usable)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    Arap arap(mesh, {.tolerance = 0});
    arap.set_handles(shapes::ends(mesh, 2));
    const Points before = solve(arap, bent);
    for (int stop : {1, 2, 5}) {
        int ticks = 0;
        Points q;
        const Progress stops([&](double, const char*) { return ++ticks < stop; });
        EXPECT_THROW(arap.solve({.poses = bent, .progress = stops}, q), Cancelled);
        EXPECT_EQ(ticks, stop);
        EXPECT_EQ(solve(arap, bent), before);
    }
}

TEST(ArapHandles, progress_of_a_bind_rises_to_one)
{
    const SurfaceMesh mesh = shapes::bar(20, 5);
    Arap arap(mesh);
    double last = 0.0;
    arap.set_handles(shapes::ends(mesh, 2), Progress([&](double fraction, const char*) {
                         EXPECT_GE(fraction, last);
                         EXPECT_LE(fraction, 1.0);
                         last = fraction;
                         return true;
                     }));
    EXPECT_EQ(last, 1.0);
}

} // namespace sinew
