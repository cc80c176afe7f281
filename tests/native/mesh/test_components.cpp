// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/components.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sinew::test_components {

TEST(Components, a_closed_surface_is_one_part)
{
    const Components parts = connected_components(shapes::cube());
    EXPECT_EQ(parts.count, 1);
    EXPECT_EQ(parts.labels, std::vector<int>(8, 0));
}

TEST(Components, are_numbered_by_their_lowest_vertex)
{
    const SurfaceMesh mesh = shapes::mesh(std::vector<Vector3>(8, Vector3::Zero()), {{7, 2, 5}, {1, 6, 4}});
    const Components parts = connected_components(mesh);
    EXPECT_EQ(parts.count, 4);
    EXPECT_EQ(parts.labels, (std::vector{0, 1, 2, 3, 1, 2, 1, 2}));
}

TEST(Components, parts_are_joined_through_faces_not_through_places)
{
    const Components parts =
        connected_components(shapes::joined(shapes::cube(), shapes::cube(), Vector3::Zero()));
    EXPECT_EQ(parts.count, 2);
}

TEST(Components, a_chain_of_many_faces_is_one_part)
{
    const SurfaceMesh strip = shapes::quad_grid(5000, 1);
    const Components parts = connected_components(strip);
    EXPECT_EQ(parts.count, 1);
    EXPECT_EQ(std::ranges::max(parts.labels), 0);
}

TEST(Components, without_faces_every_vertex_is_a_part)
{
    const Components parts = connected_components(shapes::mesh(std::vector<Vector3>(3, Vector3::Zero()), {}));
    EXPECT_EQ(parts.labels, (std::vector{0, 1, 2}));
}

} // namespace sinew::test_components
