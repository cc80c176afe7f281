// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/nonlinear/arap/cascade.h"

#include "native/core/errors.h"
#include "tests/native/shapes.h"
#include "tests/native/surface/nonlinear/graphs.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace sinew {

namespace {

struct Setting
{
    SurfaceMesh mesh;
    std::vector<Handle> handles;
    ArapGraph graph;
    ArapCascade cascade;

    explicit Setting(double smoothness = 5e-4, double weight = 1.0)
        : mesh(shapes::joined(shapes::bar(24, 6), shapes::sphere(2), {0, 30, 0})),
          handles(shapes::ends(shapes::bar(24, 6), 2)), graph(make(smoothness, weight)),
          cascade(graph, mesh.points(), {})
    {
    }

private:
    ArapGraph make(double smoothness, double weight)
    {
        handles[1].weights.assign(handles[1].vertices.size(), weight);
        return graphs::of(mesh, handles, smoothness);
    }
};

} // namespace

TEST(ArapCascade, levels_shrink_and_none_is_tiny)
{
    const Setting setting;
    int finer = setting.graph.size;
    ASSERT_GE(setting.cascade.levels().size(), 1u);
    for (const ArapLevel& level : setting.cascade.levels()) {
        EXPECT_LE(level.graph.size, finer / 3);
        EXPECT_GE(level.graph.size, 60);
        EXPECT_EQ(static_cast<int>(level.label.size()), finer);
        finer = level.graph.size;
    }
}

TEST(ArapCascade, every_node_but_the_idle_ones_is_in_one_cluster)
{
    const Setting setting;
    const ArapLevel& level = setting.cascade.levels().front();
    std::vector<int> members(level.graph.size, 0);
    for (int i = 0; i < setting.graph.size; ++i) {
        EXPECT_EQ(level.label[i] < 0, setting.graph.idle[i]);
        if (level.label[i] >= 0)
            ++members[level.label[i]];
    }
    EXPECT_EQ(members, level.members);
    EXPECT_GE(std::ranges::min(members), 1);
}

TEST(ArapCascade, clusters_never_cross_the_border_of_a_handle)
{
    const Setting setting;
    const std::vector<int>* finer = &setting.graph.hard;
    for (const ArapLevel& level : setting.cascade.levels()) {
        for (std::size_t i = 0; i < level.label.size(); ++i) {
            if (level.label[i] >= 0) {
                EXPECT_EQ(level.graph.hard[level.label[i]], (*finer)[i]);
            }
        }
        finer = &level.graph.hard;
    }
}

TEST(ArapCascade, shares_of_the_way_up_are_positive_and_sum_to_one)
{
    const Setting setting;
    for (const ArapLevel& level : setting.cascade.levels())
        for (std::size_t i = 0; i < level.label.size(); ++i) {
            if (level.label[i] < 0)
                continue;
            double sum = 0.0;
            for (int k = level.up_offsets[i]; k < level.up_offsets[i + 1]; ++k) {
                EXPECT_GE(level.up_weights[k], 0.0);
                sum += level.up_weights[k];
            }
            EXPECT_NEAR(sum, 1.0, 1e-14); // some ten shares
        }
}

TEST(ArapCascade, edges_are_symmetric_and_positive)
{
    const Setting setting;
    for (const ArapLevel& level : setting.cascade.levels()) {
        const ArapGraph& graph = level.graph;
        std::map<std::pair<int, int>, double> weights;
        for (int p = 0; p < graph.size; ++p)
            for (int a = graph.offsets[p]; a < graph.offsets[p + 1]; ++a)
                weights[{p, graph.neighbours[a]}] = graph.weights[a];
        for (const auto& [edge, weight] : weights) {
            EXPECT_GT(weight, 0.0);
            EXPECT_NEAR((weights[{edge.second, edge.first}]), weight,
                        1e-13 * weight); // summed in another order
        }
    }
}

TEST(ArapCascade, restriction_takes_means)
{
    const Setting setting;
    const ArapLevel& level = setting.cascade.levels().front();
    const Points coarse = level.restrict(view(setting.mesh.points()));
    for (int p = 0; p < level.graph.size; p += 11) {
        Vector3 mean = Vector3::Zero();
        for (int i = 0; i < setting.graph.size; ++i)
            if (level.label[i] == p)
                mean += setting.mesh.point(i) / level.members[p];
        EXPECT_LT((coarse.row(p).transpose() - mean).norm(), 1e-12);
    }
}

TEST(ArapCascade, keeps_the_sum_of_soft_pulls)
{
    const Setting setting(5e-4, 0.3);
    const auto total = [](const ArapGraph& graph) {
        double sum = 0.0;
        for (const ArapPull& pull : graph.pulls)
            sum += pull.stiffness;
        return sum;
    };
    for (const ArapLevel& level : setting.cascade.levels())
        EXPECT_NEAR(total(level.graph), total(setting.graph), 1e-10 * total(setting.graph));
}

TEST(ArapCascade, starts_a_rigid_motion_with_its_rotation)
{
    for (double smoothness : {0.0, 5e-4})
        for (double weight : {1.0, 0.3}) {
            const Setting setting(smoothness, weight);
            const Pose pose = shapes::turn({1, 2, -0.5}, 170, {3, 7, 1}, {30, -20, 10});
            const Poses poses{pose, pose};
            const Targets targets{poses, view(setting.mesh.points()), {}, nullptr};
            const ArapGoals goals(setting.graph, targets);
            ArapProblem problem(setting.graph, view(setting.mesh.points()), goals.targets, goals.pulls);
            setting.cascade.start(problem, setting.graph, targets);
            for (int i = 0; i < setting.graph.size; ++i) {
                // Idle nodes keep the identity. Where all neighbours of a node are in line, its turn is
                // settled by a pull of 1e-8 towards the one there was.
                const Matrix3 expected =
                    setting.graph.idle[i] ? Matrix3::Identity() : Matrix3(pose.leftCols<3>());
                EXPECT_LT((problem.rotation(i) - expected).norm(), 1e-7);
            }
        }
}

TEST(ArapCascade, gives_rotations_between_those_of_the_handles)
{
    const Setting setting;
    const Poses poses{shapes::still(), shapes::turn({1, 0, 0}, 90)};
    const Targets targets{poses, view(setting.mesh.points()), {}, nullptr};
    const ArapGoals goals(setting.graph, targets);
    ArapProblem problem(setting.graph, view(setting.mesh.points()), goals.targets, goals.pulls);
    setting.cascade.start(problem, setting.graph, targets);
    for (int i = 0; i < setting.graph.size; ++i) {
        const Eigen::AngleAxisd turn(problem.rotation(i));
        if (setting.graph.idle[i])
            continue;
        EXPECT_NEAR(problem.rotation(i).determinant(), 1.0, 1e-12);
        // A twisted bar turns evenly along its length, give or take the cells' own shear.
        const double along = std::clamp((setting.mesh.point(i).x() - 2) / 20, 0.0, 1.0);
        EXPECT_NEAR(turn.angle() * std::copysign(1.0, turn.axis().x()), along * shapes::pi / 2, 0.35);
    }
}

TEST(ArapCascade, blends_half_turns_about_neighbouring_axes)
{
    // Two half turns, six degrees apart, whose quaternions come out of their matrices with
    // opposite signs: the largest component is made positive.
    const Setting setting;
    const Poses poses{shapes::turn({1, -0.9, 0}, 180), shapes::turn({0.9, -1, 0}, 180)};
    const Targets targets{poses, view(setting.mesh.points()), {}, nullptr};
    const ArapGoals goals(setting.graph, targets);
    ArapProblem problem(setting.graph, view(setting.mesh.points()), goals.targets, goals.pulls);
    setting.cascade.start(problem, setting.graph, targets);
    const Matrix3 half = shapes::rotation({1, -1, 0}, 180);
    for (int i = 0; i < setting.graph.size; ++i) {
        if (setting.graph.idle[i])
            continue;
        // Six degrees to either side, and what bending adds.
        EXPECT_LT(Eigen::AngleAxisd(problem.rotation(i).transpose() * half).angle(), 0.3);
    }
}

TEST(ArapCascade, a_small_mesh_needs_no_levels)
{
    SurfaceMesh mesh = shapes::bar(6, 2);
    const ArapGraph graph = graphs::of(mesh, shapes::ends(mesh, 1), 5e-4);
    EXPECT_TRUE(ArapCascade(graph, mesh.points(), {}).levels().empty());
}

TEST(ArapCascade, can_be_cancelled_while_clustering)
{
    SurfaceMesh mesh = shapes::bar(24, 6);
    const ArapGraph graph = graphs::of(mesh, shapes::ends(mesh, 2), 5e-4);
    EXPECT_THROW(ArapCascade(graph, mesh.points(), Progress([](double, const char*) { return false; })),
                 Cancelled);
}

} // namespace sinew
