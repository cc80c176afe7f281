// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/handles/handle_groups.h"

#include "tests/native/shapes.h"

namespace sinew::test_handle_groups {

TEST(HandleGroups, have_the_handles_of_each_part)
{
    const SurfaceMesh one = shapes::octahedron();
    const SurfaceMesh mesh = shapes::joined(shapes::joined(one, one, {5, 0, 0}), one, {10, 0, 0});
    const Components parts = connected_components(mesh);
    // The first part stays free; handle 1 reaches into both others, handle 0 pulls in the last one.
    const Regions regions({{{12, 13}, {0.5, 0.0}}, {{6, 14}, {}}, {{7}, {0.0}}}, parts);
    const HandleGroups groups(regions, parts);
    EXPECT_EQ(groups.count(), 2);
    EXPECT_EQ(groups.width(), 2);
    EXPECT_EQ(groups.offsets, (std::vector<int>{0, 1, 3}));
    EXPECT_EQ(groups.handles, (std::vector<int>{1, 0, 1}));
    for (int v = 0; v < mesh.vertex_count(); ++v)
        EXPECT_EQ(groups.group[v], v / 6 - 1);
    EXPECT_EQ(groups.part_handle({6, 1}), 0);
    EXPECT_EQ(groups.part_handle({12, 0}), 1);
    EXPECT_EQ(groups.part_handle({14, 1}), 2);
    EXPECT_EQ(HandleGroups(Regions({}, parts), parts).width(), 0);
}

} // namespace sinew::test_handle_groups
