// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/riders/seat.h"

#include "tests/native/riders/scenes.h"

#include <gtest/gtest.h>

namespace sinew {

namespace {

std::vector<Seat> seats_of(const scenes::Scene& scene, std::vector<int> driven)
{
    const SurfaceMesh mesh = scene.mesh();
    const std::vector<Part> parts = parts_of(mesh, connected_components(mesh));
    std::vector<bool> flags(parts.size(), false);
    for (int part : driven)
        flags[part] = true;
    HostSurfaces surfaces;
    std::vector<Seat> seats = find_seats(parts, flags, 0.1, surfaces, {});
    for (const Seat& seat : seats)
        for (std::size_t i = 0; i < seat.samples.size(); ++i) {
            // What lies beneath lies on the triangle that is named.
            const auto& [a, b, c] = surfaces[seat.host]->triangles().at(seat.beneath.at(i).triangle);
            const std::vector<Vector3>& points = parts[seat.host].points;
            const Vector3 normal = (points[b] - points[a]).cross(points[c] - points[a]).normalized();
            EXPECT_NEAR(normal.dot(seat.beneath[i].point - points[a]), 0, 1e-12);
        }
    return seats;
}

} // namespace

TEST(Seats, are_on_the_nearest_driven_part_unless_a_larger_part_is_much_nearer)
{
    const scenes::Scene scene{scenes::plate(21, 21),         scenes::ball(1, {20, 5, 0}),
                              scenes::ball(.5, {5, 5, .8}),  scenes::ball(.2, {18.6, 5, 0}),
                              scenes::ball(.1, {5, 5, 1.4}), scenes::ball(.3, {12, 5, 0})};
    const std::vector<Seat> seats = seats_of(scene, {0, 1});
    ASSERT_EQ(seats.size(), 4u);
    EXPECT_EQ(seats[0].part, 2);
    EXPECT_EQ(seats[0].host, 0);
    EXPECT_EQ(seats[1].part, 5);
    EXPECT_EQ(seats[1].host, 0);
    EXPECT_EQ(seats[2].part, 3);
    EXPECT_EQ(seats[2].host, 1);
    EXPECT_EQ(seats[3].part, 4);
    EXPECT_EQ(seats[3].host, 2) << "the small ball rides on the large one, not on the plate below";
}

TEST(Seats, of_a_part_between_two_driven_ones_are_all_on_one)
{
    scenes::Piece other = scenes::plate(21, 21);
    for (Vector3& p : other.points)
        p.x() += 10.5;
    const std::vector<Seat> seats =
        seats_of({scenes::plate(21, 21), other, scenes::block({4, 1, .1}, {10, 5, .3}, {8, 2, 1})}, {0, 1});
    ASSERT_EQ(seats.size(), 1u);
    EXPECT_EQ(seats[0].beneath.size(), seats[0].samples.size());
}

TEST(Seats, there_are_none_where_no_driven_part_has_an_area)
{
    const scenes::Piece point{{Vector3(0, 0, 0)}, {}};
    EXPECT_TRUE(seats_of({point, scenes::ball(1, {3, 0, 0})}, {0}).empty());
}

} // namespace sinew
