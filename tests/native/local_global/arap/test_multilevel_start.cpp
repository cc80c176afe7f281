// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/multilevel_start.h"

#include "native/core/errors.h"
#include "tests/native/local_global/arap/graphs.h"
#include "tests/native/shapes.h"

#include <Eigen/LU>

namespace sinew::test_multilevel_start {

struct Setting
{
    SurfaceMesh mesh;
    std::vector<Handle> handles;
    ArapSystem graph;
    MultilevelStart cascade;

    Setting()
        : mesh(shapes::joined(shapes::bar(24, 6), shapes::sphere(2), {0, 30, 0})),
          handles(shapes::ends(shapes::bar(24, 6), 2)), graph(graphs::of(mesh, handles, 5e-4)),
          cascade(graph, mesh.points(), {})
    {
    }

    /// The rotation that each node begins with.
    std::vector<Matrix3> started(const Poses& poses) const
    {
        const Targets targets{poses, view(mesh.points()), {}, nullptr};
        const GraphGoals goals(graph, targets);
        ArapProblem problem(graph, view(mesh.points()), goals.targets, goals.pulls);
        std::vector<GraphWorkspace> work;
        CascadeSolve(cascade, problem, graph, targets, work).start();
        std::vector<Matrix3> rotations;
        for (int i = 0; i < graph.size(); ++i)
            rotations.push_back(problem.rotation(i));
        return rotations;
    }
};

TEST(MultilevelStart, levels_shrink_and_none_is_tiny)
{
    const Setting setting;
    int finer = setting.graph.size();
    ASSERT_GE(setting.cascade.levels().size(), 1u);
    for (const RotationLevel& level : setting.cascade.levels()) {
        EXPECT_LE(level.graph.size(), finer / 3);
        EXPECT_GE(level.graph.size(), 60);
        EXPECT_EQ(static_cast<int>(level.map.label().size()), finer);
        finer = level.graph.size();
    }
}

TEST(MultilevelStart, gives_rotations_between_those_of_the_handles)
{
    const Setting setting;
    const std::vector<Matrix3> rotations = setting.started({shapes::still(), shapes::turn({1, 0, 0}, 90)});
    for (int i = 0; i < setting.graph.size(); ++i) {
        const Eigen::AngleAxisd turn(rotations[i]);
        if (setting.graph.nodes().is_idle(i))
            continue;
        EXPECT_NEAR(rotations[i].determinant(), 1.0, 1e-12);
        // A twisted bar turns evenly along its length, give or take the cells' own shear.
        const double along = std::clamp((setting.mesh.point(i).x() - 2) / 20, 0.0, 1.0);
        EXPECT_NEAR(turn.angle() * std::copysign(1.0, turn.axis().x()), along * shapes::pi / 2, 0.35);
    }
}

TEST(MultilevelStart, blends_half_turns_about_neighbouring_axes)
{
    // Two half turns, six degrees apart, whose quaternions come out of their matrices with
    // opposite signs: the largest component is made positive.
    const Setting setting;
    const std::vector<Matrix3> rotations =
        setting.started({shapes::turn({1, -0.9, 0}, 180), shapes::turn({0.9, -1, 0}, 180)});
    const Matrix3 half = shapes::rotation({1, -1, 0}, 180);
    for (int i = 0; i < setting.graph.size(); ++i) {
        if (setting.graph.nodes().is_idle(i))
            continue;
        // Six degrees to either side, and what bending adds.
        EXPECT_LT(Eigen::AngleAxisd(rotations[i].transpose() * half).angle(), 0.3);
    }
}

TEST(MultilevelStart, a_small_mesh_needs_no_levels)
{
    SurfaceMesh mesh = shapes::bar(6, 2);
    const ArapSystem graph = graphs::of(mesh, shapes::ends(mesh, 1), 5e-4);
    EXPECT_TRUE(MultilevelStart(graph, mesh.points(), {}).levels().empty());
}

TEST(MultilevelStart, can_be_cancelled_while_clustering)
{
    SurfaceMesh mesh = shapes::bar(24, 6);
    const ArapSystem graph = graphs::of(mesh, shapes::ends(mesh, 2), 5e-4);
    EXPECT_THROW(MultilevelStart(graph, mesh.points(), Progress([](double, const char*) { return false; })),
                 Cancelled);
}

} // namespace sinew::test_multilevel_start
