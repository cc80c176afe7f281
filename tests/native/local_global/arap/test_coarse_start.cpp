// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/coarse_start.h"

#include "native/local_global/rows/goals.h"
#include "native/mesh/components.h"
#include "tests/native/shapes.h"

namespace sinew::test_coarse_start {

struct Setting
{
    SurfaceMesh mesh;
    Regions regions;
    CoarseStart start;

    explicit Setting(const SurfaceMesh& bar, double smoothing = 0.5)
        : mesh(shapes::joined(bar, shapes::sphere(1), {0, 30, 0})),
          regions(shapes::ends(bar, 2), connected_components(mesh)), start(mesh, regions, smoothing)
    {
    }

    std::vector<Eigen::Quaterniond> rotations(const Poses& poses,
                                              std::optional<PointsView> incoming = {}) const
    {
        std::vector<Eigen::Quaterniond> result;
        CoarseStart::Workspace work;
        start.rotations({poses, view(mesh.points()), incoming, nullptr}, work, result);
        return result;
    }
};

/// Once with clusters, once on a mesh that is too small for them.
TEST(CoarseStart, turns_a_bar_evenly_along_its_length)
{
    for (const int around : {6, 2}) {
        const Setting setting(shapes::bar(24, around));
        const auto rotations = setting.rotations({shapes::still(), shapes::turn({1, 0, 0}, 90)});
        for (int i = 0; i < setting.mesh.vertex_count(); ++i) {
            if (setting.regions.is_idle(i)) {
                EXPECT_EQ(rotations[i].angularDistance(Eigen::Quaterniond::Identity()), 0.0);
                continue;
            }
            const Eigen::AngleAxisd turn(rotations[i]);
            // The cells' own shear and the clusters make it uneven.
            const double along = std::clamp((setting.mesh.point(i).x() - 2) / 20, 0.0, 1.0);
            EXPECT_NEAR(turn.angle() * std::copysign(1.0, turn.axis().x()), along * shapes::pi / 2, 0.35)
                << around << " " << i;
        }
    }
}

TEST(CoarseStart, follows_a_rigid_motion)
{
    for (const int around : {6, 2}) {
        const Setting setting(shapes::bar(24, around));
        const Pose pose = shapes::turn({1, 2, 3}, 170);
        const Eigen::Quaterniond expected(Matrix3(pose.leftCols<3>()));
        const Points incoming = 1.5 * setting.mesh.points();
        for (const auto& shape : {std::optional<PointsView>(), std::optional<PointsView>(view(incoming))}) {
            const auto rotations = setting.rotations({pose, pose}, shape);
            for (int i = 0; i < setting.mesh.vertex_count(); ++i)
                if (!setting.regions.is_idle(i)) {
                    EXPECT_LT(rotations[i].angularDistance(expected), 1e-6) << around << " " << i;
                }
        }
    }
}

TEST(CoarseStart, does_nothing_where_all_is_held)
{
    const SurfaceMesh bar = shapes::bar(24, 2);
    const Regions regions({{shapes::numbers(0, bar.vertex_count()), {}}}, connected_components(bar));
    const CoarseStart start(bar, regions, 0.5);
    EXPECT_EQ(start.factor_bytes(), 0);
    std::vector<Eigen::Quaterniond> rotations;
    CoarseStart::Workspace work;
    const Poses poses{shapes::turn({0, 0, 1}, 30)};
    start.rotations({poses, view(bar.points()), {}, nullptr}, work, rotations);
    ASSERT_EQ(static_cast<int>(rotations.size()), bar.vertex_count());
    EXPECT_EQ(rotations[0].w(), 1.0);
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
    const Points rest = 0.5 * bar.points();
    const Points incoming = 2.0 * bar.points();
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
