// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/regions.h"

#include "tests/native/shapes.h"

namespace sinew::test_regions {

/// Two parts: 0-5 and 6-8.
const Components two_parts{2, {0, 0, 0, 0, 0, 0, 1, 1, 1}};

TEST(Regions, tell_held_free_and_idle_vertices_apart)
{
    const Regions regions({{{1, 2}, {}}, {{4}, {}}}, two_parts);
    EXPECT_EQ(regions.handle_count(), 2);
    EXPECT_EQ(regions.vertex_count(), 9);
    EXPECT_EQ(regions.hard(2), 0);
    EXPECT_EQ(regions.hard(4), 1);
    EXPECT_EQ(regions.hard(0), -1);
    EXPECT_TRUE(regions.is_free(0));
    EXPECT_FALSE(regions.is_free(1));
    EXPECT_TRUE(regions.is_idle(7));
    EXPECT_FALSE(regions.is_free(7));
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

TEST(Regions, a_part_whose_weights_are_all_zero_is_idle)
{
    const Regions regions({{{7}, {0.0}}, {{0}, {}}}, two_parts);
    EXPECT_TRUE(regions.is_idle(7));
    EXPECT_EQ(regions.report().free_parts, 1);
}

TEST(Regions, a_hard_constraint_overrides_soft_ones_whatever_the_order)
{
    const Handle hard{{3}, {}};
    const Handle soft{{3, 4}, {0.5, 0.5}};
    for (const auto& handles : {std::vector{hard, soft}, std::vector{soft, hard}}) {
        const Regions regions(handles, two_parts);
        EXPECT_GE(regions.hard(3), 0);
        ASSERT_EQ(regions.soft().size(), 1u);
        EXPECT_EQ(regions.soft()[0].vertex, 4);
    }
}

TEST(Regions, soft_constraints_of_several_handles_on_a_vertex_all_count)
{
    const Regions regions({{{3}, {0.5}}, {{3}, {0.25}}}, two_parts);
    EXPECT_EQ(regions.soft().size(), 2u);
    EXPECT_EQ(regions.report().soft_vertices, 1);
}

TEST(Regions, constraints_are_the_hard_ones_by_vertex_then_the_soft_ones)
{
    const Regions regions({{{5, 2}, {}}, {{4, 1}, {0.5, 1.0}}}, two_parts);
    const auto all = regions.constraints();
    ASSERT_EQ(all.size(), 4u);
    const std::vector<std::pair<int, int>> expected{{1, 1}, {2, 0}, {5, 0}, {4, 1}};
    for (std::size_t k = 0; k < all.size(); ++k)
        EXPECT_EQ(std::pair(all[k].vertex, all[k].handle), expected[k]);
}

TEST(Regions, a_vertex_named_twice_by_one_handle_is_held_once)
{
    EXPECT_EQ(Regions({{{2, 2, 3}, {}}}, two_parts).report().constrained_vertices, 2);
}

TEST(Regions, the_report_counts)
{
    const BindReport report = Regions({{{0, 1}, {}}, {{2, 3}, {0.5, 0.5}}}, two_parts).report();
    EXPECT_EQ(report.handle_count, 2);
    EXPECT_EQ(report.constrained_vertices, 2);
    EXPECT_EQ(report.soft_vertices, 2);
    EXPECT_EQ(report.free_parts, 1);
    EXPECT_EQ(report.free_vertices, (std::vector{6, 7, 8}));
    EXPECT_EQ(Regions({}, two_parts).report().free_parts, 2);
    EXPECT_EQ(Regions({}, two_parts).report().free_vertices.size(), 9u);
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
