// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/graph/surface_fronts.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace sinew::test_surface_fronts {

namespace {

std::vector<float> from(const SurfaceMesh& mesh, int source, float far = SurfaceFronts::infinite)
{
    const SurfaceFronts fronts(mesh);
    SurfaceFronts::Front front(fronts);
    std::vector<float> found(static_cast<std::size_t>(mesh.vertex_count()), SurfaceFronts::infinite);
    for (int round = 0; round < 2; ++round) // the second from a used one
        front.from(
            source, [&](int v) { return far + fronts.margin(v); },
            [&](int v, float distance) { found[v] = distance; });
    return found;
}

} // namespace

TEST(SurfaceFronts, are_straight_in_a_plane_however_it_is_folded)
{
    const SurfaceMesh regular = shapes::grid(30, 20);
    Points plane = regular.points(), accordion = plane; // of strips between the rows
    for (Eigen::Index v = 0; v < plane.rows(); ++v) {
        const double y = plane(v, 1);
        if (plane(v, 0) > 0 && plane(v, 0) < 30) // the border stays straight
            plane(v, 0) += 0.3 * std::sin(static_cast<double>(v * v));
        accordion.row(v) << plane(v, 0), 0.8 * y, 0.6 * (static_cast<int>(y) % 2);
    }
    const SurfaceMesh flat = shapes::moved(regular, plane), folded = shapes::moved(regular, accordion);
    for (const int source : {0, 17, 300}) {
        const std::vector<float> found = from(folded, source);
        for (int v = 0; v < flat.vertex_count(); ++v) {
            const double straight = (flat.point(v) - flat.point(source)).norm();
            // Least gains of 1e-5, and fronts that met an edge before its other end was known.
            EXPECT_NEAR(found[v], straight, 2e-3 * straight) << source << " to " << v;
        }
    }
}

TEST(SurfaceFronts, are_near_great_circles_on_a_sphere)
{
    const SurfaceMesh sphere = shapes::sphere(4);
    const std::vector<float> found = from(sphere, 0);
    for (int v = 1; v < sphere.vertex_count(); ++v) {
        const double arc = std::acos(std::clamp(sphere.point(v).dot(sphere.point(0)), -1.0, 1.0));
        // Facets are shorter, and fronts that bend over edges are no longer those of points.
        EXPECT_NEAR(found[v], arc, 0.03 * arc) << v;
    }
}

TEST(SurfaceFronts, that_end_early_are_right_as_far_as_they_go)
{
    for (const SurfaceMesh& mesh :
         {shapes::grid(40, 40, 0.025, 0.3), shapes::sphere(4), shapes::bar(24, 6)}) {
        const std::vector<float> whole = from(mesh, 5);
        const float far = 0.3F * *std::ranges::max_element(whole);
        const std::vector<float> some = from(mesh, 5, far);
        for (int v = 0; v < mesh.vertex_count(); ++v)
            EXPECT_NEAR(some[v], whole[v], whole[v] < far ? 1e-4F * whole[v] : SurfaceFronts::infinite)
                << v; // ten least gains
    }
}

TEST(SurfaceFronts, take_faces_without_area_and_parts_that_they_do_not_reach)
{
    const std::vector<float> found = from(shapes::messy(), 0);
    for (const float distance : found)
        EXPECT_FALSE(std::isnan(distance));
    const SurfaceMesh two = shapes::joined(shapes::sphere(1), shapes::sphere(1), {3, 0, 0});
    EXPECT_EQ(from(two, 0).back(), SurfaceFronts::infinite);
}

} // namespace sinew::test_surface_fronts
