// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/skeleton/bone_regions.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sinew::test_bone_regions {

namespace {

Skeleton in_a_bar()
{
    Points heads(2, 3), tails(2, 3);
    heads << 0, 0, 0, 12, 0, 0;
    tails << 12, 0, 0, 24, 0, 0;
    return {heads, tails, {-1, 0}};
}

} // namespace

TEST(BoneRegions, LimbsAreHeldAndJointsAreFree)
{
    const SurfaceMesh mesh = shapes::bar(24, 3);
    const auto regions = bone_regions(mesh, in_a_bar());
    // A root has no joint at its head, and the last bone none at its tail: these ends are held.
    EXPECT_EQ(regions[0], shapes::where(mesh, [](const Vector3& p) { return p.x() <= 9; }));
    EXPECT_EQ(regions[1], shapes::where(mesh, [](const Vector3& p) { return p.x() >= 15; }));
    const auto wide = bone_regions(mesh, in_a_bar(), 0.4);
    EXPECT_LT(wide[0].size(), regions[0].size());
}

TEST(BoneRegions, DistancesGoAlongTheSurface)
{
    // Two bars side by side. The bone in the first one is nearer to the inner side of the other than that
    // one's own bone, which lies far out in it.
    const SurfaceMesh one = shapes::bar(12, 2);
    const SurfaceMesh both = shapes::joined(one, one, {0, 2.2, 0});
    Points heads(2, 3), tails(2, 3);
    heads << 0, 0.6, 0, 0, 2.9, 0;
    tails << 12, 0.6, 0, 12, 2.9, 0;
    const auto regions = bone_regions(both, Skeleton(heads, tails, {-1, -1}));
    const auto of_second = [&](int v) { return v >= one.vertex_count(); };
    EXPECT_EQ(std::ranges::count_if(regions[1], of_second), one.vertex_count());
    EXPECT_TRUE(std::ranges::none_of(regions[0], of_second));
    // The same where all faces look inward.
    EXPECT_EQ(bone_regions(shapes::inside_out(both), Skeleton(heads, tails, {-1, -1})), regions);
}

TEST(BoneRegions, ABoneOutsideHoldsNothing)
{
    const SurfaceMesh mesh = shapes::bar(24, 3);
    Points heads(2, 3), tails(2, 3);
    heads << 0, 0, 0, 0, 5, 0;
    tails << 24, 0, 0, 24, 5, 0;
    const auto regions = bone_regions(mesh, Skeleton(heads, tails, {-1, -1}));
    EXPECT_EQ(static_cast<int>(regions[0].size()), mesh.vertex_count());
    EXPECT_TRUE(regions[1].empty());
}

} // namespace sinew::test_bone_regions
