// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/part.h"

#include "tests/native/attachments/scenes.h"

namespace sinew::test_part {

Part part_of(const scenes::Piece& piece)
{
    const SurfaceMesh mesh = scenes::Scene({piece}).mesh();
    return parts_of(mesh, connected_components(mesh)).front();
}

double thickness(const scenes::Piece& piece) { return ClosedPart(part_of(piece)).thickness(); }

TEST(Part, the_centre_is_the_lowest_of_the_points_nearest_the_centroid)
{
    EXPECT_EQ(part_of(scenes::block({1, 1, 1}, {50, 0, 0}, {1, 1, 1})).centre(), 0);
    const Part plate = part_of(scenes::plate(21, 21));
    EXPECT_NEAR((plate.points[plate.centre()] - Vector3(5, 5, 0)).norm(), 0, 1e-12);
    Part line; // no area
    line.points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    EXPECT_EQ(line.centre(), 1);
}

TEST(ClosedPart, thickness_of_simple_bodies)
{
    EXPECT_NEAR(thickness(scenes::ball(1, {3, 4, 5}, 96, 64)), 2, .01);
    EXPECT_NEAR(thickness(scenes::ball(1, {3, 4, 5}, 96, 64).inside_out()), 2, .01);
    EXPECT_NEAR(thickness(scenes::block({2, 2, 2}, {1, 0, 0}, {3, 3, 3})), 2, 1e-12);
    EXPECT_NEAR(thickness(scenes::block({100, 100, 1}, {0, 0, 0}, {3, 3, 1})), 3, .1);
    EXPECT_EQ(thickness(scenes::plate(5, 5)), 0) << "its fan lies in its plane";
    // An open tube is closed by a fan at each end.
    const scenes::Piece open = scenes::sheet(11, 90, false, true, [](double a, double b) {
        return Vector3(10 * a, std::cos(2 * shapes::pi * b), std::sin(2 * shapes::pi * b));
    });
    const ClosedPart closed(part_of(open));
    EXPECT_EQ(closed.points.size(), open.points.size() + 2);
    EXPECT_EQ(closed.triangles.size(), open.triangles.size() + 180);
    EXPECT_NEAR(closed.thickness(), 6 * 10 * shapes::pi / (22 * shapes::pi), .01);
}

} // namespace sinew::test_part
