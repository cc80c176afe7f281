// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/coarse_start.h"

#include "native/local_global/rows/goals.h"
#include "native/mesh/components.h"
#include "tests/native/shapes.h"

namespace sinew::test_coarse_start {

/// Once with clusters, once on a mesh that is too small for them.
TEST(CoarseStart, turns_a_bar_evenly_along_its_length)
{
    for (const int around : {6, 2}) {
        const SurfaceMesh mesh = shapes::joined(shapes::bar(24, around), shapes::sphere(1), {0, 30, 0});
        const Regions regions(shapes::ends(shapes::bar(24, around), 2), connected_components(mesh));
        std::vector<Eigen::Quaterniond> rotations;
        CoarseStart::Workspace work;
        const Poses poses{shapes::still(), shapes::turn({1, 0, 0}, 90)};
        CoarseStart(mesh, regions, 0.5).rotations({poses, view(mesh.points()), {}, nullptr}, work, rotations);
        for (int i = 0; i < mesh.vertex_count(); ++i) {
            if (regions.is_idle(i)) {
                EXPECT_EQ(rotations[i].angularDistance(Eigen::Quaterniond::Identity()), 0.0);
                continue;
            }
            const Eigen::AngleAxisd turn(rotations[i]);
            // The cells' own shear and the clusters make it uneven.
            const double along = std::clamp((mesh.point(i).x() - 2) / 20, 0.0, 1.0);
            EXPECT_NEAR(turn.angle() * std::copysign(1.0, turn.axis().x()), along * shapes::pi / 2, 0.35)
                << around << " " << i;
        }
    }
}

TEST(Goals, name_where_each_vertex_is_wanted)
{
    const SurfaceMesh bar = shapes::bar(4, 1);
    const Regions regions({{.vertices = {0}, .weights = {}}, {.vertices = {1, 2}, .weights = {0.5, 0.75}}},
                          connected_components(bar));
    RowTable rows(bar.vertex_count(), 1);
    const RowTable::Term terms[] = {{1, 1.0}, {2, -2.0}};
    rows.add(3.0, terms, 0);
    add_pulls(regions, rows);
    ASSERT_EQ(rows.pulls().size(), 2u);
    EXPECT_DOUBLE_EQ(rows.pulls()[0].stiffness, 1.0 * 3.0);
    EXPECT_DOUBLE_EQ(rows.pulls()[1].stiffness, 3.0 * 12.0);
    const std::vector<bool> held = held_vertices(regions);
    EXPECT_TRUE(held[0]);
    EXPECT_EQ(std::ranges::count(held, true), 1);

    const Poses poses{shapes::turn({0, 0, 1}, 90), shapes::still()};
    const Points rest = 0.5 * bar.points(), incoming = 2.0 * bar.points();
    const std::vector<bool> from_rest{true, false};
    TargetsInUnit scaled;
    const Targets targets =
        scaled.of({poses, view(bar.points()), view(incoming), &from_rest}, view(rest), 2.0);
    Goals goals;
    goals.set(regions, targets);
    EXPECT_LT((goals.held.row(0).transpose() - poses[0].leftCols<3>() * rest.row(0).transpose() -
               0.5 * poses[0].col(3))
                  .norm(),
              1e-15);
    EXPECT_LT((goals.held.row(3) - 0.5 * incoming.row(3)).norm(), 1e-15);
    EXPECT_LT((goals.pulls.row(1) - 0.5 * incoming.row(2)).norm(), 1e-15);
}

} // namespace sinew::test_coarse_start
