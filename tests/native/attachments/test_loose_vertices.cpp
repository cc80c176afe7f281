// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/loose_vertices.h"

#include "tests/native/attachments/scenes.h"

namespace sinew::test_loose_vertices {

TEST(LooseVertices, stay_on_the_surface_and_at_their_height_above_it)
{
    const std::vector<double> heights{0, 0, 0, 0, .05, .05, .3, 1};
    scenes::Scene scene{scenes::plate(41, 41)};
    for (std::size_t k = 0; k < heights.size(); ++k)
        scene.add({{Vector3(1.03 + .7 * static_cast<double>(k), 4.87, heights[k])}, {}});
    const scenes::Carried carried(scene);
    EXPECT_EQ(carried.attachments.rides().size(), heights.size());
    for (double radius : {20.0, 8.0}) {
        const auto by = [&](const Vector3& p) { return scenes::rolled(p, radius); };
        const Points exact = carried.deformed(by), moved = carried.moved(by);
        for (int k = 0; k < static_cast<int>(heights.size()); ++k) {
            const int v = carried.scene.body() + k;
            // The base reaches to its distance and an edge more: the sag of its chord, and its tilt.
            const double base = heights[k] + .25, sag = .25 * .25 / 8 / radius;
            const double allowed = heights[k] > 0 ? (base + heights[k]) * base / 2 / radius : sag;
            EXPECT_LT((moved.row(v) - exact.row(v)).norm(), allowed) << k << " " << radius;
        }
    }
}

TEST(LooseVertices, far_away_and_beside_the_border_move_with_similarities)
{
    scenes::Scene scene{scenes::plate(21, 21)};
    for (const Vector3& p :
         {Vector3(5, 5, 1e4), Vector3(-300, 5, 0), Vector3(10, 10, 0), Vector3(12, 12, -3)})
        scene.add({{p}, {}});
    const scenes::Carried carried(scene);
    const Pose pose = shapes::affine(.3 * shapes::rotation({3, 2, 1}, -57), {1, 2, 3});
    const Points all = shapes::transformed(carried.mesh.points(), pose);
    EXPECT_LT(shapes::distance(carried.moved(all), all), 1e-12 * 1e4);
    const Points incoming = carried.deformed([](const Vector3& p) { return scenes::twisted(p); });
    const Points twisted = shapes::transformed(incoming, pose);
    EXPECT_LT(shapes::distance(carried.moved(twisted, view(incoming)), twisted), 1e-12 * 1e4);
}

TEST(LooseVertices, listen_to_a_wide_base_where_they_are_high_above)
{
    const SurfaceMesh mesh = scenes::Scene{scenes::plate(41, 41)}.mesh();
    const std::vector<Part> parts = parts_of(mesh, connected_components(mesh));
    HostSurface host(parts[0]);
    host.prepare_tree();
    const auto width = [&](const Vector3& vertex) {
        const Triangle t = carriers_of(host, host.tree().closest_place(vertex), vertex);
        return (parts[0].points[t[1]] - parts[0].points[t[0]]).norm();
    };
    EXPECT_LE(width({5.1, 5.1, .01}), .36);
    EXPECT_GT(width({5.1, 5.1, 1}), 1);
    EXPECT_LT(width({5.1, 5.1, 1e6}), 6);
}

} // namespace sinew::test_loose_vertices
