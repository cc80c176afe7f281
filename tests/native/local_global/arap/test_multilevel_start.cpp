// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/multilevel_start.h"

#include "tests/native/local_global/arap/graphs.h"
#include "tests/native/shapes.h"

namespace sinew::test_multilevel_start {

TEST(MultilevelStart, its_levels_shrink_and_give_rotations_between_those_of_the_handles)
{
    SurfaceMesh small = shapes::bar(6, 2);
    const ArapSystem of_small = graphs::of(small, shapes::ends(small, 1), 5e-4);
    EXPECT_TRUE(MultilevelStart(of_small, small.points(), {}).levels().empty());

    SurfaceMesh mesh = shapes::joined(shapes::bar(24, 6), shapes::sphere(2), {0, 30, 0});
    const ArapSystem graph = graphs::of(mesh, shapes::ends(shapes::bar(24, 6), 2), 5e-4);
    const MultilevelStart cascade(graph, mesh.points(), {});
    int finer = graph.size();
    ASSERT_GE(cascade.levels().size(), 1u);
    for (const RotationLevel& level : cascade.levels()) {
        EXPECT_LE(level.graph.size(), finer / 3);
        EXPECT_GE(level.graph.size(), 60);
        EXPECT_EQ(static_cast<int>(level.map.label().size()), finer);
        finer = level.graph.size();
    }

    const Poses poses{shapes::still(), shapes::turn({1, 0, 0}, 90)};
    const Targets targets{poses, view(mesh.points()), {}, nullptr};
    const GraphGoals goals(graph, targets);
    ArapProblem problem(graph, view(mesh.points()), goals.targets, goals.pulls);
    std::vector<GraphWorkspace> work;
    CascadeSolve(cascade, problem, graph, targets, work).start();
    for (int i = 0; i < graph.size(); ++i) {
        if (graph.nodes().is_idle(i))
            continue;
        EXPECT_NEAR(problem.rotation(i).determinant(), 1.0, 1e-12);
        // A twisted bar turns evenly along its length, give or take the cells' own shear.
        const Eigen::AngleAxisd turn(problem.rotation(i));
        const double along = std::clamp((mesh.point(i).x() - 2) / 20, 0.0, 1.0);
        EXPECT_NEAR(turn.angle() * std::copysign(1.0, turn.axis().x()), along * shapes::pi / 2, 0.35);
    }
}

} // namespace sinew::test_multilevel_start
