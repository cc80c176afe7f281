// SPDX-License-Identifier: GPL-3.0-or-later
// What every surface method does with parts that ride on others.
#include "tests/native/methods/surface/calls.h"

#include <gtest/gtest.h>

namespace sinew::contract_free_parts {

namespace {

using calls::Method, calls::solve;

const FreeParts follow{.follow = true};

/// A mesh with a small ball and a long strip a little above its middle.
SurfaceMesh dressed(const SurfaceMesh& mesh)
{
    const Points& p = mesh.points();
    const double length = p.col(0).maxCoeff() - p.col(0).minCoeff();
    const Vector3 at(p.col(0).mean(), p.col(1).mean(), p.col(2).maxCoeff() + .02 * length);
    const SurfaceMesh ball =
        shapes::moved(shapes::octahedron(), .02 * length * shapes::octahedron().points());
    const SurfaceMesh strip = shapes::grid(30, 1, .02 * length);
    return shapes::joined(shapes::joined(mesh, ball, at), strip, at + Vector3(-.3 * length, .05 * length, 0));
}

constexpr int ball_vertices = 6, strip_vertices = 62;

Method bound(const SurfaceVariant& variant, const SurfaceMesh& mesh, const std::vector<Handle>& handles,
             const FreeParts& free_parts = follow)
{
    Method method = variant.make(mesh);
    method->set_handles(handles, {}, free_parts);
    return method;
}

/// A rigid motion that the method reproduces.
Pose motion(const SurfaceTraits& traits)
{
    return traits.rigid ? shapes::turn({1, 2, -0.5}, 170, {3, 7, 1}, {30, -20, 10}) : shapes::shift(3, -2, 5);
}

double exactly(const SurfaceTraits& traits, const Points& shape)
{
    const double size = shapes::size(shape);
    return 1e-11 * size + (traits.rigid ? *traits.rigid * size : traits.translation);
}

} // namespace

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(SurfaceContract);

TEST_P(SurfaceContract, the_report_says_what_rides_on_what)
{
    const SurfaceMesh all = dressed(mesh());
    const int n = mesh().vertex_count();
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = variant.make(all);
        const BindReport report = method->set_handles(ends(), {}, follow);
        ASSERT_EQ(report.rides.size(), 2u);
        EXPECT_EQ(report.free_parts, 0);
        EXPECT_TRUE(report.free_vertices.empty());
        EXPECT_EQ(static_cast<int>(report.riding_vertices.size()), ball_vertices + strip_vertices);
        EXPECT_EQ(report.riding_vertices.front(), n);
        EXPECT_EQ(report.factorizations, variant.factorizations);
        EXPECT_EQ(report.rides[0].part, 1);
        EXPECT_EQ(report.rides[0].first_vertex, n);
        EXPECT_EQ(report.rides[0].vertex_count, ball_vertices);
        EXPECT_EQ(report.rides[0].host, 0);
        EXPECT_EQ(report.rides[0].frame_count, 1);
        EXPECT_EQ(report.rides[1].first_vertex, n + ball_vertices);
        EXPECT_EQ(report.rides[1].vertex_count, strip_vertices);
        EXPECT_GT(report.rides[1].frame_count, 1);
        // A part that a handle touches, even softly, is no free part.
        std::vector<Handle> handles = ends();
        handles.push_back({{n + 1}, {.5}});
        const BindReport held = method->set_handles(handles, {}, follow);
        ASSERT_EQ(held.rides.size(), 1u);
        EXPECT_EQ(held.rides[0].part, 2);
        EXPECT_TRUE(method->set_handles({}, {}, follow).rides.empty()) << "there is nothing to ride on";
        EXPECT_EQ(solve(*method, {}), all.points());
    }
}

TEST_P(SurfaceContract, parts_that_ride_rest_with_the_rest_and_move_rigidly_with_all_handles)
{
    const SurfaceMesh all = dressed(mesh());
    const Pose pose = motion(traits());
    const Points moved = shapes::transformed(all.points(), pose);
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = bound(variant, all, ends());
        EXPECT_LT(shapes::distance(solve(*method, Poses(2, shapes::still())), all.points()),
                  1e-12 * shapes::size(all.points()) + 10 * traits().rest);
        EXPECT_LT(shapes::distance(solve(*method, {pose, pose}), moved), exactly(traits(), moved));
    }
}

TEST_P(SurfaceContract, parts_that_ride_follow_and_nothing_else_feels_them)
{
    const SurfaceMesh all = dressed(mesh());
    const int n = mesh().vertex_count();
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Points staying = solve(*bound(variant, all, ends(), {}), traits().bent);
        const Points q = solve(*bound(variant, all, ends()), traits().bent);
        EXPECT_EQ(q.topRows(n), staying.topRows(n));
        EXPECT_GT(shapes::distance(q.bottomRows(strip_vertices), staying.bottomRows(strip_vertices)),
                  .01 * shapes::size(all.points()));
        EXPECT_EQ(staying.bottomRows(strip_vertices), all.points().bottomRows(strip_vertices));
    }
}

TEST_P(SurfaceContract, parts_that_ride_go_from_the_incoming_shape)
{
    const SurfaceMesh all = dressed(mesh());
    const double size = shapes::size(all.points());
    Points incoming = shapes::transformed(all.points(), shapes::turn({0, 0, 1}, 50, {1, 0, 0}));
    for (int v = 0; v < incoming.rows(); ++v) // a gentle bend, as an armature makes
        incoming(v, 2) += .2 / size * incoming(v, 0) * incoming(v, 0);
    const Pose pose = motion(traits());
    const Points moved = shapes::transformed(incoming, pose);
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = bound(variant, all, ends());
        EXPECT_LT(shapes::distance(solve(*method, Poses(2, shapes::still()), {.incoming = view(incoming)}),
                                   incoming),
                  1e-11 * size + 10 * traits().incoming);
        EXPECT_LT(shapes::distance(solve(*method, {pose, pose}, {.incoming = view(incoming)}), moved),
                  exactly(traits(), moved) + (traits().rigid ? 1e-10 : 0));
    }
}

TEST_P(SurfaceContract, rebind_takes_over_what_rides_and_keeps_the_factor_where_only_that_changes)
{
    const SurfaceMesh all = dressed(mesh());
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method first = bound(variant, all, ends());
        const Points before = solve(*first, traits().bent);
        const Method second = variant.make(all);
        const BindReport kept = second->rebind(*first, ends(), {}, follow);
        EXPECT_EQ(kept.reuse, Reuse::kept);
        EXPECT_EQ(kept.rides.size(), 2u);
        EXPECT_EQ(solve(*second, traits().bent), before);

        const Method third = variant.make(all);
        EXPECT_THROW(third->rebind(*second, ends(), {}, {.follow = true, .stiffness = {2.0}}), InvalidOption);
        EXPECT_EQ(solve(*second, traits().bent), before);
        const BindReport staying = third->rebind(*second, ends());
        EXPECT_EQ(staying.reuse, Reuse::updated);
        EXPECT_EQ(staying.changed, "free_parts");
        EXPECT_EQ(staying.factorizations, variant.factorizations);
        EXPECT_EQ(staying.free_parts, 2);
        EXPECT_TRUE(staying.rides.empty());
        EXPECT_EQ(static_cast<int>(staying.free_vertices.size()), ball_vertices + strip_vertices);
        EXPECT_EQ(solve(*third, traits().bent), solve(*bound(variant, all, ends(), {}), traits().bent));

        const Method fourth = variant.make(all);
        EXPECT_EQ(fourth->rebind(*third, ends(), {}, follow).free_parts, 0);
        EXPECT_EQ(solve(*fourth, traits().bent), before);
    }
}

} // namespace sinew::contract_free_parts
