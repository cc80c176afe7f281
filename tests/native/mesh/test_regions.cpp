// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/regions.h"

#include "tests/native/shapes.h"

namespace sinew::test_regions {

/// Two parts: 0-5 and 6-8.
const Components two_parts{2, {0, 0, 0, 0, 0, 0, 1, 1, 1}};

TEST(Regions, tell_held_free_and_idle_vertices_apart)
{
    const Regions regions({{{1, 2, 2}, {}}, {{4}, {}}, {{7, 8}, {0.0, 0.0}}}, two_parts);
    EXPECT_EQ(regions.handle_count(), 3);
    const std::vector<int> hard{-1, 0, 0, -1, 1, -1, -1, -1, -1};
    for (int v = 0; v < regions.vertex_count(); ++v) {
        EXPECT_EQ(regions.hard(v), hard[v]);
        EXPECT_EQ(regions.is_free(v), v < 6 && hard[v] < 0);
        EXPECT_EQ(regions.is_idle(v), v >= 6) << "weights of zero hold nothing";
    }
    EXPECT_EQ(regions.report().constrained_vertices, 3) << "one of them is named twice";
    EXPECT_EQ(regions.report().free_parts, 1);
}

TEST(Regions, a_weight_of_one_holds_less_pulls_and_zero_lets_go)
{
    const Regions regions({{{0, 1, 2}, {1.0, 0.25, 0.0}}}, two_parts);
    EXPECT_EQ(regions.hard(0), 0);
    EXPECT_EQ(regions.hard(1), -1);
    ASSERT_EQ(regions.soft().size(), 1u);
    EXPECT_EQ(regions.soft()[0].vertex, 1);
    EXPECT_DOUBLE_EQ(regions.soft()[0].stiffness(), 1.0 / 3.0);
    EXPECT_TRUE(regions.is_free(2));
}

TEST(Regions, a_hard_constraint_overrides_soft_ones_whatever_the_order_and_soft_ones_all_count)
{
    const Handle hard{{3}, {}}, soft{{3, 4}, {0.5, 0.5}}, other{{4}, {0.25}};
    for (const auto& handles : {std::vector{hard, soft, other}, std::vector{soft, other, hard}}) {
        const Regions regions(handles, two_parts);
        EXPECT_GE(regions.hard(3), 0);
        ASSERT_EQ(regions.soft().size(), 2u);
        EXPECT_EQ(regions.soft()[0].vertex, 4);
        EXPECT_EQ(regions.report().soft_vertices, 1);
    }
}

TEST(Regions, constraints_are_the_hard_ones_by_vertex_then_the_soft_ones_and_the_report_counts_them)
{
    const Regions regions({{{5, 2}, {}}, {{4, 1}, {0.5, 1.0}}}, two_parts);
    std::vector<std::pair<int, int>> found;
    for (const auto& constraint : regions.constraints())
        found.emplace_back(constraint.vertex, constraint.handle);
    EXPECT_EQ(found, (std::vector<std::pair<int, int>>{{1, 1}, {2, 0}, {5, 0}, {4, 1}}));
    const BindReport report = regions.report(), none = Regions({}, two_parts).report();
    EXPECT_EQ(report.handle_count, 2);
    EXPECT_EQ(report.constrained_vertices, 3);
    EXPECT_EQ(report.soft_vertices, 1);
    EXPECT_EQ(report.free_vertices, (std::vector{6, 7, 8}));
    EXPECT_EQ(none.free_parts, 2);
    EXPECT_EQ(none.free_vertices.size(), 9u);
}

TEST(Targets, apply_the_pose_to_the_incoming_point_or_to_the_rest)
{
    const Points rest = shapes::points_of({{1, 0, 0}, {0, 1, 0}});
    const Points incoming = shapes::points_of({{5, 0, 0}, {0, 5, 0}});
    const Poses poses{shapes::turn({0, 0, 1}, 90), shapes::shift(0, 0, 2)};
    const std::vector<bool> from_rest{false, true};
    const Targets targets{poses, view(rest), view(incoming), &from_rest};
    EXPECT_TRUE(targets.position(0, 0).isApprox(Vector3(0, 5, 0)));
    EXPECT_TRUE(targets.position(1, 1).isApprox(Vector3(0, 1, 2)));
    const Targets at_rest{poses, view(rest), {}, nullptr};
    EXPECT_TRUE(at_rest.position(0, 1).isApprox(Vector3(1, 0, 2)));
}

} // namespace sinew::test_regions
