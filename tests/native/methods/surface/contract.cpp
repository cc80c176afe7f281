// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/native/methods/surface/calls.h"

#include "tests/native/refusals.h"

namespace sinew::surface_contract {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
using calls::bound, calls::Method, calls::softened, calls::solve;

double worst_gap(const Points& from, const Points& q, const std::vector<int>& vertices, const Pose& pose)
{
    double gap = 0.0;
    for (int v : vertices)
        gap = std::max(gap, (q.row(v).transpose() - apply(pose, from.row(v).transpose())).norm());
    return gap;
}

void expect_near(const Points& found, const Points& expected, double tolerance)
{
    if (tolerance == 0.0) {
        EXPECT_EQ(found, expected);
    } else {
        EXPECT_LT(shapes::distance(found, expected), tolerance);
    }
}

} // namespace

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(SurfaceContract);

TEST_P(SurfaceContract, rest_in_rest_out)
{
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = bound(variant, mesh(), ends());
        Points positions;
        const SolveReport report = method->solve({Poses(2, shapes::still())}, positions);
        expect_near(positions, mesh().points(), traits().rest);
        EXPECT_LT(report.energy, 1e-20);
        EXPECT_TRUE(report.converged);
    }
}

TEST_P(SurfaceContract, translating_all_handles_translates_everything)
{
    for (const SurfaceVariant& variant : traits().variants)
        for (double weight : {1.0, 0.4}) {
            SCOPED_TRACE(variant.name);
            const Method method = bound(variant, mesh(), softened(ends(), weight));
            EXPECT_LT(shapes::distance(solve(*method, Poses(2, shapes::shift(3, -2, 5))),
                                       mesh().points().rowwise() + Eigen::RowVector3d(3, -2, 5)),
                      traits().translation);
        }
}

TEST_P(SurfaceContract, rigid_motion_of_all_handles_is_exact_from_the_start)
{
    if (!traits().rigid)
        GTEST_SKIP() << "not reproduced by this method";
    for (const SurfaceVariant& variant : traits().variants)
        for (double angle : {5.0, 90.0, 170.0, 180.0, 270.0})
            for (double weight : {1.0, 0.3}) {
                SCOPED_TRACE(variant.name + ", " + std::to_string(angle) + " degrees");
                const Pose pose = shapes::turn({1, 2, -0.5}, angle, {3, 7, 1}, {30, -20, 10});
                const Points expected = shapes::transformed(mesh().points(), pose);
                const Method method = bound(variant, mesh(), softened(ends(), weight));
                for (int budget : {0, 10}) {
                    Points q;
                    const SolveReport report =
                        method->solve({.poses = {pose, pose}, .max_iterations = budget}, q);
                    EXPECT_LT(shapes::distance(q, expected), *traits().rigid * shapes::size(expected));
                    if (traits().iterative) {
                        EXPECT_LT(report.energy, 1e-18);
                    }
                }
            }
    const Pose pose = shapes::turn({1, 2, -0.5}, 170, {3, 7, 1}, {30, -20, 10});
    const Points expected = shapes::transformed(traits().large.points(), pose);
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = bound(variant, traits().large, shapes::ends(traits().large, traits().depth));
        EXPECT_LT(shapes::distance(solve(*method, {pose, pose}, {.max_iterations = 0}), expected),
                  *traits().rigid * shapes::size(expected));
    }
}

TEST_P(SurfaceContract, hard_handles_are_met_and_soft_ones_the_better_the_nearer_their_weight_is_to_one)
{
    for (const SurfaceVariant& variant : traits().variants)
        for (int h : {0, 1})
            EXPECT_LT(worst_gap(mesh().points(), solve(*bound(variant, mesh(), ends()), traits().bent),
                                ends()[h].vertices, traits().bent[h]),
                      traits().held)
                << variant.name;
    const Method method = traits().variants.front().make(mesh());
    double before = std::numeric_limits<double>::infinity();
    for (double weight : {0.01, 0.2, 0.9, 0.999, 0.999999}) {
        const std::vector<Handle> handles = softened(ends(), weight);
        EXPECT_EQ(method->set_handles(handles).soft_vertices, static_cast<int>(handles[1].vertices.size()));
        const Points q = solve(*method, traits().bent, {.max_iterations = traits().soft_iterations});
        const double gap = worst_gap(mesh().points(), q, handles[1].vertices, traits().bent[1]);
        EXPECT_LT(gap, before) << weight;
        before = gap;
    }
    EXPECT_LT(before, traits().soft);
}

TEST_P(SurfaceContract, all_handles_may_be_soft)
{
    std::vector<Handle> handles = softened(ends(), 0.7);
    handles[0].weights.assign(handles[0].vertices.size(), 0.7);
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Points q = solve(*bound(variant, mesh(), handles), traits().bent);
        EXPECT_TRUE(q.allFinite());
        EXPECT_LT(worst_gap(mesh().points(), q, handles[1].vertices, traits().bent[1]), traits().all_soft);
    }
}

TEST_P(SurfaceContract, a_single_vertex_can_be_a_handle)
{
    std::vector<Handle> handles = ends();
    handles[1].vertices.resize(1);
    const Method method = bound(traits().variants.front(), mesh(), handles);
    const Pose lift = shapes::shift(0, 3, 2);
    const Points q = solve(*method, {shapes::still(), lift});
    EXPECT_TRUE(q.allFinite());
    EXPECT_LT(worst_gap(mesh().points(), q, handles[1].vertices, lift), traits().alone);
    // One vertex alone: the whole part follows.
    method->set_handles({{{0}, {}}});
    EXPECT_LT(shapes::distance(solve(*method, {lift}), shapes::transformed(mesh().points(), lift)),
              traits().translation);
}

TEST_P(SurfaceContract, before_any_handle_the_shape_that_comes_in_goes_out)
{
    for (const SurfaceMesh* shape : sizes())
        for (const SurfaceVariant& variant : traits().variants) {
            SCOPED_TRACE(variant.name);
            const Points incoming = 2 * shape->points();
            const Method method = variant.make(*shape);
            for (int time : {1, 2}) {
                EXPECT_EQ(solve(*method, {}), shape->points());
                EXPECT_EQ(solve(*method, {}, {.incoming = view(incoming)}), incoming);
                if (time == 1) {
                    EXPECT_EQ(method->set_handles({}).free_parts, 1);
                }
            }
        }
}

TEST_P(SurfaceContract, weights_of_zero_hold_nothing)
{
    for (const SurfaceMesh* shape : sizes())
        for (const SurfaceVariant& variant : traits().variants) {
            SCOPED_TRACE(variant.name);
            std::vector<Handle> handles = softened(shapes::ends(*shape, traits().depth), 0.0);
            handles[0].weights.assign(handles[0].vertices.size(), 0.0);
            const Method method = variant.make(*shape);
            EXPECT_EQ(method->set_handles(handles).free_parts, 1);
            EXPECT_EQ(solve(*method, traits().bent), shape->points());
        }
}

TEST_P(SurfaceContract, handles_may_hold_every_vertex)
{
    const Pose pose = traits().bent[1];
    for (const SurfaceMesh* shape : sizes())
        for (const SurfaceVariant& variant : traits().variants) {
            SCOPED_TRACE(variant.name);
            const Method method =
                bound(variant, *shape, {{shapes::where(*shape, [](const Vector3&) { return true; }), {}}});
            EXPECT_LT(shapes::distance(solve(*method, {pose}), shapes::transformed(shape->points(), pose)),
                      3e-15 * shapes::size(shape->points()));
        }
}

TEST_P(SurfaceContract, most_of_a_mesh_may_be_without_a_handle)
{
    const SurfaceMesh small = shapes::sphere(1);
    const int n = small.vertex_count();
    for (const SurfaceMesh* shape : sizes())
        for (const SurfaceVariant& variant : traits().variants) {
            SCOPED_TRACE(variant.name);
            const SurfaceMesh both = shapes::joined(small, *shape, {0, 40, 0});
            const Method method = bound(variant, both, {{{0}, {}}});
            const Points q = solve(*method, {shapes::shift(1, 2, 3)});
            EXPECT_EQ(q.bottomRows(shape->vertex_count()), both.points().bottomRows(shape->vertex_count()));
            EXPECT_LT(shapes::distance(q.topRows(n), small.points().rowwise() + Eigen::RowVector3d(1, 2, 3)),
                      traits().translation);
        }
}

TEST_P(SurfaceContract, a_part_without_a_handle_stays_and_the_others_do_not_feel_it)
{
    const SurfaceMesh other = shapes::sphere(1);
    const int n = mesh().vertex_count(), idle = other.vertex_count();
    const SurfaceMesh both = shapes::joined(mesh(), other, {0, 20, 0});
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = variant.make(both);
        const BindReport report = method->set_handles(ends());
        EXPECT_EQ(report.free_parts, 1);
        ASSERT_EQ(static_cast<int>(report.free_vertices.size()), idle);
        EXPECT_EQ(report.free_vertices.front(), n);
        const Points q = solve(*method, traits().bent);
        EXPECT_EQ(q.bottomRows(idle), both.points().bottomRows(idle));
        if (variant.separate) {
            EXPECT_LT(shapes::distance(q.topRows(n), solve(*bound(variant, mesh(), ends()), traits().bent)),
                      traits().apart);
        }
        Points incoming = both.points();
        incoming.bottomRows(idle).rowwise() += Eigen::RowVector3d(0, 0, 9);
        EXPECT_EQ(solve(*method, traits().bent, {.incoming = view(incoming)}).bottomRows(idle),
                  incoming.bottomRows(idle));
        EXPECT_EQ(solve(*method, traits().bent, {.substeps = 3}).bottomRows(idle),
                  both.points().bottomRows(idle));
    }
}

TEST_P(SurfaceContract, each_part_follows_its_own_handles)
{
    const int n = mesh().vertex_count();
    const SurfaceMesh both = shapes::joined(mesh(), mesh(), {0, 20, 0});
    std::vector<Handle> handles = ends();
    handles.push_back({{n + 3, n + n / 3, n + n / 2}, {}});
    const Pose pose = traits().rigid ? shapes::turn({0, 0, 1}, 100, {0, 20, 0}) : shapes::shift(1, 2, 3);
    const Method method = bound(traits().variants.front(), both, handles);
    const Points q = solve(*method, {traits().bent[0], traits().bent[1], pose});
    const Points expected = shapes::transformed(both.points().bottomRows(n), pose);
    EXPECT_LT(shapes::distance(q.bottomRows(n), expected), 1e-6);
}

TEST_P(SurfaceContract, an_incoming_pose_passes_through_where_no_handle_moves)
{
    const Points incoming = shapes::Random(3).shaken(mesh().points(), traits().noise);
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = bound(variant, mesh(), ends());
        expect_near(solve(*method, Poses(2, shapes::still()), {.incoming = view(incoming)}), incoming,
                    traits().incoming);
        const Points rest = solve(*method, traits().bent, {.incoming = view(mesh().points())});
        EXPECT_LT(shapes::distance(rest, solve(*method, traits().bent)), 1e-10) << "the rest is none";
        const Pose pose =
            traits().rigid ? shapes::turn({1, 1, 0}, 150, {0, 3, 0}, {1, 2, 3}) : shapes::shift(1, 2, 3);
        EXPECT_LT(shapes::distance(solve(*method, {pose, pose}, {.incoming = view(incoming)}),
                                   shapes::transformed(incoming, pose)),
                  traits().rigid ? 1e-10 : traits().translation);
    }
}

TEST_P(SurfaceContract, a_handle_that_aims_from_rest_ignores_the_incoming_pose)
{
    const Method method = bound(traits().variants.front(), mesh(), ends());
    const Points incoming = mesh().points().rowwise() + Eigen::RowVector3d(0, 1, 5);
    const Points q = solve(*method, traits().bent,
                           {.incoming = view(incoming), .from_rest = std::vector<bool>{false, true}});
    EXPECT_LT(worst_gap(mesh().points(), q, ends()[1].vertices, traits().bent[1]), 1e-13);
    EXPECT_LT(worst_gap(incoming, q, ends()[0].vertices, traits().bent[0]), 1e-13);
}

TEST_P(SurfaceContract, solves_on_messy_meshes)
{
    const SurfaceMesh messy = shapes::messy();
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = variant.make(messy);
        const BindReport report = method->set_handles({{{0, 1, 9, 10}, {}}, {{79, 80, 70, 71}, {}}});
        EXPECT_EQ(report.free_parts, 2); // the triangle of its own, the loose vertex
        EXPECT_EQ(report.degenerate_faces, traits().degenerate_faces);
        const std::vector<Poses> lifted{{shapes::still(), shapes::shift(1, 2, 3)},
                                        {shapes::still(), shapes::turn({0, 0, 1}, 40, {8, 8, 0}, {1, 2, 3})}};
        for (const Poses& poses : lifted) {
            double before = std::numeric_limits<double>::infinity();
            for (int k : {0, 1, 2, 4, 8, 40}) {
                Points q;
                const SolveReport solved =
                    method->solve({.poses = poses, .max_iterations = k, .tolerance = 0.0}, q);
                EXPECT_TRUE(q.allFinite());
                EXPECT_LT(shapes::distance(q, messy.points()), traits().messy) << "nothing flies off";
                EXPECT_LE(solved.energy, before * (1 + 1e-12));
                before = solved.energy;
            }
        }
    }
}

TEST_P(SurfaceContract, faces_of_one_corner_repeated_change_nothing)
{
    shapes::Polygons faces = shapes::faces_of(mesh());
    for (int v : {0, 20, 48})
        faces.push_back({v, v, v});
    const SurfaceMesh folded = shapes::over(mesh().points(), faces);
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        EXPECT_LT(shapes::distance(solve(*bound(variant, folded, ends()), traits().bent),
                                   solve(*bound(variant, mesh(), ends()), traits().bent)),
                  traits().folded); // the same sums, in another order
    }
}

TEST_P(SurfaceContract, meshes_without_any_area_are_solved_or_refused)
{
    for (double line : {0.0, 1.0}) {
        Points p = Points::Zero(25, 3);
        p.col(0) = line * shapes::grid_points(4, 4).col(0);
        for (const SurfaceVariant& variant : traits().variants) {
            const Method method = variant.make(shapes::moved(shapes::grid(4, 4), p));
            try {
                method->set_handles({{{0, 1, 2, 5, 6}, {}}, {{24}, {}}});
                EXPECT_TRUE(solve(*method, {shapes::still(), shapes::shift(0, 0, 1)}).allFinite());
            } catch (const FactorizationFailed&) {
                // A point has no metric: a typed refusal is an answer.
            }
        }
    }
}

TEST_P(SurfaceContract, the_same_request_gives_the_same_bits_whatever_came_before)
{
    const Points incoming =
        shapes::transformed(traits().large.points(), shapes::turn({1, 0, 2}, 20, {0, 0, 0}, {1, 2, 3}));
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method used = bound(variant, traits().large, shapes::ends(traits().large, traits().depth));
        const Points first = solve(*used, traits().bent);
        const std::vector<SolveRequest> requests{
            {}, {.incoming = view(incoming)}, {.start = view(first)}, {.max_iterations = 0}};
        for (SolveRequest request : requests) {
            request.poses = traits().drag(0.3);
            Points after, fresh;
            const SolveReport report = used->solve(request, after);
            EXPECT_EQ(bound(variant, traits().large, shapes::ends(traits().large, traits().depth))
                          ->solve(request, fresh)
                          .energy,
                      report.energy);
            EXPECT_EQ(after, fresh);
        }
        EXPECT_EQ(solve(*used, traits().bent), first);
    }
}

TEST_P(SurfaceContract, ten_solves_take_one_factorisation)
{
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = variant.make(traits().large);
        EXPECT_EQ(method->set_handles(shapes::ends(traits().large, traits().depth)).factorizations,
                  variant.factorizations);
        for (int k = 0; k < 10; ++k)
            solve(*method, traits().drag(0.1 * k), {.max_iterations = 2});
        const std::vector<Handle> deeper = shapes::ends(traits().large, traits().depth + 1);
        EXPECT_EQ(method->set_handles(deeper).factorizations, 2 * variant.factorizations);
    }
}

TEST_P(SurfaceContract, a_dragged_handle_moves_the_surface_without_jumps_and_back_again)
{
    const Method method =
        bound(traits().variants.front(), traits().large, shapes::ends(traits().large, traits().depth));
    const std::vector<int> held = shapes::ends(traits().large, traits().depth)[1].vertices;
    const Points first = solve(*method, traits().drag(0.0));
    Points before = first;
    for (int k = 1; k <= traits().drag_steps; ++k) {
        const Points now =
            solve(*method, traits().drag(static_cast<double>(k % traits().drag_steps) / traits().drag_steps));
        double handle_step = 0.0;
        for (int v : held)
            handle_step = std::max(handle_step, (now.row(v) - before.row(v)).norm());
        EXPECT_LT(shapes::distance(now, before), traits().follow * handle_step + traits().slack)
            << "step " << k;
        before = now;
    }
    EXPECT_EQ(before, first); // the same poses, the same bits
}

TEST_P(SurfaceContract, a_refused_or_cancelled_bind_leaves_everything_as_it_was)
{
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = bound(variant, traits().large, shapes::ends(traits().large, traits().depth));
        const Points before = solve(*method, traits().bent);
        EXPECT_THROW(method->set_handles({{{}, {}}}), InvalidConstraint);
        EXPECT_THROW(method->set_handles({{{0}, {}}, {{0}, {}}}), InvalidConstraint);
        EXPECT_EQ(solve(*method, traits().bent), before);
        const std::vector<Handle> others = shapes::ends(traits().large, traits().depth + 2);
        int cancelled = 0;
        for (int stop = 1;; ++stop) {
            int ticks = 0;
            try {
                method->set_handles(others, Progress([&](double, const char*) { return ++ticks < stop; }));
                break;
            } catch (const Cancelled&) {
                ++cancelled;
                EXPECT_EQ(solve(*method, traits().bent), before) << "cancelled at tick " << stop;
            }
        }
        EXPECT_GE(cancelled, 3); // assembling, factorising, bound
        EXPECT_EQ(solve(*method, traits().bent),
                  solve(*bound(variant, traits().large, others), traits().bent));
    }
}

TEST_P(SurfaceContract, a_bind_above_the_memory_limit_is_refused_and_the_last_one_stays)
{
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = bound(variant, traits().large, shapes::ends(traits().large, traits().depth));
        const Points before = solve(*method, traits().bent);
        {
            const MemoryLimit limit(1000);
            const std::vector<Handle> deeper = shapes::ends(traits().large, traits().depth + 2);
            EXPECT_THROW(method->set_handles(deeper), OutOfMemory);
        }
        EXPECT_EQ(solve(*method, traits().bent), before);
    }
}

TEST_P(SurfaceContract, a_cancelled_solve_leaves_the_object_usable)
{
    const Method method = bound(traits().variants.front(), mesh(), ends());
    const Points before = solve(*method, traits().bent);
    for (int stop : {1, 2, 5}) {
        int ticks = 0;
        Points q;
        const Progress stops([&](double, const char*) { return ++ticks < stop; });
        try {
            method->solve({.poses = traits().bent, .tolerance = 0.0, .progress = stops}, q);
            EXPECT_LT(ticks, stop) << "a linear method ends before it asks";
        } catch (const Cancelled&) {
            EXPECT_EQ(ticks, stop);
        }
        EXPECT_EQ(solve(*method, traits().bent), before);
    }
}

TEST_P(SurfaceContract, progress_of_a_bind_rises_to_one)
{
    for (const SurfaceVariant& variant : traits().variants) {
        double last = 0.0;
        variant.make(mesh())->set_handles(ends(), Progress([&](double fraction, const char* stage) {
                                              EXPECT_GE(fraction, last);
                                              EXPECT_LE(fraction, 1.0);
                                              EXPECT_STRNE(stage, "");
                                              last = fraction;
                                              return true;
                                          }));
        EXPECT_EQ(last, 1.0);
    }
}

TEST_P(SurfaceContract, refuses_what_does_not_fit_a_solve)
{
    const Method method = bound(traits().variants.front(), mesh(), ends());
    const Points other = Points::Zero(3, 3);
    Points broken = mesh().points();
    broken(4, 1) = nan;
    const auto refused = [&](const SolveRequest& request) {
        Points out;
        EXPECT_THROW(method->solve(request, out), InvalidConstraint);
    };
    const Poses& bent = traits().bent;
    refused({{shapes::still()}});
    refused({Poses(3, shapes::still())});
    for (double bad : {nan, std::numeric_limits<double>::infinity()}) {
        Poses poses = bent;
        poses[1](0, 0) = bad;
        refused({poses});
    }
    refused({.poses = bent, .incoming = view(other)});
    refused({.poses = bent, .from_rest = std::vector<bool>(3, true)});
    refused({.poses = bent, .start = view(other)});
    refused({.poses = bent, .start = view(broken)});
    EXPECT_THROW(solve(*method, bent, {.max_iterations = -1}), InvalidOption);
    EXPECT_THROW(solve(*method, bent, {.tolerance = -1.0}), InvalidOption);
    EXPECT_THROW(solve(*method, bent, {.tolerance = nan}), InvalidOption);
    Poses turned = bent;
    turned[1](2, 3) = nan;
    const auto broken_pose = [&] { solve(*method, turned); };
    expect_elements(refusal<InvalidConstraint>(broken_pose), Error::Element::handle, {1});
    const auto broken_enters = [&] { solve(*method, bent, {.incoming = view(broken)}); };
    expect_elements(refusal<InvalidConstraint>(broken_enters), Error::Element::vertex, {4});
}

} // namespace sinew::surface_contract
