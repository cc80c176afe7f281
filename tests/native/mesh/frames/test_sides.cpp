// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/frames/sides.h"

#include "tests/native/shapes.h"

namespace sinew::test_sides {

TEST(Sides, are_those_of_the_larger_area)
{
    for (const SurfaceMesh& mesh : {shapes::sphere(2), shapes::bar(4, 2), shapes::hill(5, 4)}) {
        EXPECT_TRUE(with_sides_of_the_whole(mesh) == mesh);
        shapes::Polygons faces = shapes::faces_of(mesh);
        for (const std::size_t f : {std::size_t{0}, faces.size() / 2, faces.size() / 2 + 1})
            std::reverse(faces[f].begin() + 1, faces[f].end());
        EXPECT_TRUE(with_sides_of_the_whole(shapes::over(mesh.points(), faces)) == mesh);
        for (std::vector<int>& face : faces) // now three lie as before, and all others inside out
            std::reverse(face.begin() + 1, face.end());
        EXPECT_FALSE(with_sides_of_the_whole(shapes::over(mesh.points(), faces)) == mesh);
    }
}

TEST(Sides, of_a_surface_with_one_side_stay)
{
    constexpr int around = 12;
    std::vector<Vector3> points;
    shapes::Polygons faces;
    for (int k = 0; k < around; ++k)
        for (const double side : {-0.3, 0.3}) {
            const double angle = 2 * shapes::pi * k / around, half = angle / 2;
            const double radius = 1 + side * std::cos(half);
            points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), side * std::sin(half));
        }
    for (int k = 0; k < around; ++k) {
        const int a = 2 * k, b = a + 1, c = k + 1 < around ? a + 2 : 1, d = k + 1 < around ? a + 3 : 0;
        faces.push_back({a, b, d, c});
    }
    const SurfaceMesh strip = shapes::mesh(points, faces);
    EXPECT_TRUE(with_sides_of_the_whole(strip) == strip);
}

} // namespace sinew::test_sides
