// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/closed_forms/cage_geometry.h"

#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

namespace sinew::test_cage_geometry {

TEST(CageGeometry, is_about_the_middle_in_units_of_the_size)
{
    const SurfaceMesh far = shapes::moved(shapes::cube(), (1e3 * shapes::cube().points()).rowwise() +
                                                              Eigen::RowVector3d(7e6, 0, 0));
    const Cage cage(far);
    const CageGeometry geometry{cage};
    // 1e-9 is what coordinates of 7e6 leave
    const Vector3 corner = cage.frame().in(Vector3(7e6 + 1e3, 500, 500));
    EXPECT_NEAR(geometry.normalized(corner).x(), 0.5 / std::sqrt(3.0), 1e-12);
    const CageTables tables = geometry.tables();
    EXPECT_EQ(tables.edge_count, 18);
    EXPECT_EQ(tables.triangle_count, 12);
    EXPECT_NEAR(tables.triangles[0].double_area, 1.0 / 3.0, 1e-15);
}

TEST(CageGeometry, brings_points_into_reach_along_their_way)
{
    const CageGeometry geometry{Cage(shapes::cube())};
    const Vector3 near(3, 4, 5);
    EXPECT_EQ(geometry.within_reach(near), near);
    const Vector3 far = geometry.within_reach({3e200, 4e200, 0});
    EXPECT_NEAR((far - Vector3(600, 800, 0)).norm(), 0.0, 1e-12);
}

TEST(CageGeometry, knows_the_nearest_triangle_and_its_coordinates)
{
    const CageGeometry geometry{Cage(shapes::octahedron())};
    const Vector3 x(0.2, 0.25, 0.3); // units of the size 2 sqrt 3: before the first triangle's middle
    ASSERT_EQ(geometry.nearest(x), 0);
    EXPECT_LT(geometry.depth(0, x), 0.0);
    EXPECT_NEAR(geometry.barycentric(0, x).sum(), 1.0, 1e-15);
    EXPECT_NEAR(geometry.square_distance(0, x), geometry.depth(0, x) * geometry.depth(0, x), 1e-15);
    const Vector3 beyond(2, 0, 0);
    EXPECT_NEAR(geometry.square_distance(0, beyond), std::pow(2.0 - 1.0 / std::sqrt(12.0), 2), 1e-14);
}

TEST(CageGeometry, leaves_out_triangles_without_a_plane)
{
    const Cage cage(cages::cube_with_a_flat_triangle());
    const CageGeometry geometry(cage);
    EXPECT_EQ(geometry.tables().triangle_count, static_cast<int>(cage.triangles().size()) - 1);
}

} // namespace sinew::test_cage_geometry
