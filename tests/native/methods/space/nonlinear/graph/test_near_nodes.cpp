// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/graph/near_nodes.h"

#include "native/methods/space/nonlinear/graph/deformation_graph.h"
#include "tests/native/methods/space/nonlinear/legs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace sinew::test_near_nodes {

namespace {

using Shares = std::vector<BlendedMaps::Share>;

double sum_of(const Shares& shares)
{
    double sum = 0.0;
    for (const auto& share : shares)
        sum += share.weight;
    return sum;
}

/// How many vertices of one leg follow a node of the other, well below the join.
int glued(const SurfaceMesh& mesh, const std::vector<int>& nodes, const std::function<Shares(int)>& shares)
{
    int count = 0;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        for (const auto& share : shares(v))
            if (legs::side(mesh.point(v)) * legs::side(mesh.point(nodes[share.map])) < 0) {
                ++count;
                break;
            }
    return count;
}

} // namespace

TEST(NearNodes, has_four_nodes_per_vertex_with_the_weights_of_the_formula)
{
    const SurfaceMesh mesh = shapes::grid(20, 20);
    const NearNodes near(mesh, 30, {});
    EXPECT_EQ(near.nodes().size(), 30);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        const Shares own = near.shares(v);
        ASSERT_LE(own.size(), 4);
        EXPECT_NEAR(sum_of(own), 1.0, 1e-14);
        std::vector<double> straight; // in a plane, the ways are straight
        for (const int node : near.nodes())
            straight.push_back((mesh.point(node) - mesh.point(v)).norm());
        std::ranges::sort(straight);
        const double farthest = std::min(straight[4], 3.0 * near.radius());
        double sum = 0.0, first = 0.0;
        for (int k = 0; k < 4; ++k) {
            const double w = std::pow(std::max(0.0, 1.0 - straight[k] / farthest), 2);
            first = k == 0 ? w : first;
            sum += w;
        }
        double largest = 0.0;
        for (const auto& share : own)
            largest = std::max(largest, share.weight);
        EXPECT_NEAR(largest, first / sum, 2e-3) << v; // fronts stop at a ten-thousandth
    }
}

TEST(NearNodes, legs_side_by_side_share_no_node)
{
    const SurfaceMesh mesh = legs::pair();
    const NearNodes near(mesh, 60, {});
    EXPECT_EQ(glued(mesh, near.nodes(), [&](int v) { return near.shares(v); }), 0);
    EXPECT_GT(glued(mesh, near.nodes(), [&](int v) { return near.straight_shares(mesh.point(v)); }), 20)
        << "straight distances would glue them, so the test says something";
}

TEST(NearNodes, measures_small_parts_and_clouds_straight)
{
    const SurfaceMesh body = shapes::sphere(3);
    Points button = 0.02 * shapes::sphere(0).points();
    const SurfaceMesh both = shapes::joined(body, shapes::moved(shapes::sphere(0), button), {1.03, 0, 0});
    const NearNodes near(both, 40, {});
    for (int v = body.vertex_count(); v < both.vertex_count(); ++v) {
        EXPECT_FALSE(near.is_on_surface(v));
        for (const auto& share : near.shares(v))
            EXPECT_LT(near.nodes()[share.map], body.vertex_count()) << "the button has no node of its own";
    }
    const SurfaceMesh cloud(shapes::sphere(3).points(), {}, {});
    const NearNodes points(cloud, 40, {});
    for (int v = 0; v < cloud.vertex_count(); ++v)
        EXPECT_NEAR(sum_of(points.shares(v)), 1.0, 1e-14);
}

TEST(NearNodes, takes_few_and_coincident_points)
{
    for (const int count : {1, 2, 4, 7}) {
        Points points = Points::Zero(count, 3);
        for (int k = 1; k < count; ++k)
            points(k, 0) = k % 3; // some coincide
        const SurfaceMesh mesh(points, {}, {});
        const NearNodes near(mesh, 300, {});
        EXPECT_LE(near.nodes().size(), 3);
        for (int v = 0; v < count; ++v)
            EXPECT_NEAR(sum_of(near.shares(v)), 1.0, 1e-14);
    }
}

/// As Blender has it after Apply Rotation and Scale.
TEST(DeformationGraph, does_not_depend_on_the_axes)
{
    const std::vector<std::pair<SurfaceMesh, int>> cases{
        {shapes::quad_grid(10, 10, 0.2), 300}, // each vertex is a node
        {shapes::quad_grid(40, 40, 0.05), 60},
        {shapes::sphere(4), 60},
        {shapes::bar(24, 6), 60},
        {shapes::grid(60, 60, 1.0, 0.3), 60},
        {legs::pair(), 60},
        {SurfaceMesh(shapes::sphere(3).points(), {}, {}), 40}};
    shapes::Random random(5);
    for (const auto& [given, wanted] : cases) {
        const Points rest = given.points().cast<float>().cast<double>();
        const SurfaceMesh mesh = shapes::moved(given, rest);
        const DeformationGraph graph(mesh, wanted, {});
        const auto shares = graph.shares(view(rest));
        for (int round = 0; round < 4; ++round) {
            Pose pose = shapes::turn(random.vector(), 180 * random.unit(), {0, 0, 0}, random.vector());
            pose.leftCols<3>() *= 1.0 + random.unit();
            const Points turned = shapes::transformed(rest, pose).cast<float>().cast<double>();
            const SurfaceMesh other = shapes::moved(given, turned);
            const DeformationGraph same(other, wanted, {});
            EXPECT_EQ(same.edges(), graph.edges());
            EXPECT_LT(shapes::distance(same.places(), shapes::transformed(graph.places(), pose)),
                      1e-6 * shapes::size(turned));
            const auto others = same.shares(view(turned));
            double off = 0.0;
            for (std::size_t v = 0; v < shares.size(); ++v) {
                ASSERT_EQ(shares[v].size(), others[v].size()) << v;
                std::map<int, double> change;
                for (std::size_t k = 0; k < shares[v].size(); ++k) {
                    change[shares[v][k].map] += shares[v][k].weight;
                    change[others[v][k].map] -= others[v][k].weight;
                }
                for (const auto& [node, by] : change)
                    off = std::max(off, std::abs(by));
            }
            EXPECT_LT(off, 1e-4) << "rounding of the points to single precision, over the spacing of nodes";
        }
    }
}

TEST(DeformationGraph, connects_parts_that_are_near_and_no_others)
{
    for (const auto& [apart, wanted] : {std::pair(2.2, 1), std::pair(5.0, 4)}) { // of balls of diameter 2
        SurfaceMesh mesh = shapes::sphere(3);
        for (int k = 1; k < 4; ++k)
            mesh = shapes::joined(mesh, shapes::sphere(3), k * Vector3(apart, 0.2 * apart, 0));
        const DeformationGraph graph(mesh, 50, {});
        std::vector<int> piece(graph.size());
        for (int j = 0; j < graph.size(); ++j)
            piece[j] = j;
        for (int round = 0; round < graph.size(); ++round)
            for (const auto& [a, b] : graph.edges())
                piece[a] = piece[b] = std::min(piece[a], piece[b]);
        EXPECT_EQ(std::set(piece.begin(), piece.end()).size(), wanted);
        for (int i = 0; i < graph.size(); ++i)
            for (int j = 0; j < graph.size(); ++j)
                EXPECT_EQ(graph.pieces()[i] == graph.pieces()[j], piece[i] == piece[j]);
    }
}

} // namespace sinew::test_near_nodes
