// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/green.h"

#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sinew::test_green {

namespace {

GreenOptions doubles(GreenOutside outside = GreenOutside::nearest, int exit_face = -1)
{
    return {cages::doubles, outside, exit_face};
}

SpaceTraits traits()
{
    const SurfaceMesh cage = shapes::u_prism();
    return {.name = "Green",
            .variants = {cages::variant<Green>("nearest", cage, doubles())},
            .control = cage.points(),
            .points = shapes::points_around(cage, 600, 1.0),
            .similarity = 1e-11,
            .follow = 3.0, // normals turn with the faces at the vertex
            .other = [cage] { return std::make_shared<Green>(Cage(cage), doubles(GreenOutside::face, 1)); }};
}

/// A cube of 6 n^2 quads on a bumpy sphere, none of them flat.
SurfaceMesh quad_ball(int n, double bumps)
{
    std::vector<Vector3> points;
    shapes::Polygons faces;
    const auto corner = [&](const Vector3& on_cube) {
        const Vector3 p = on_cube.normalized();
        for (std::size_t i = 0; i < points.size(); ++i)
            if ((points[i] - p).norm() < 1e-9)
                return static_cast<int>(i);
        points.push_back(p);
        return static_cast<int>(points.size()) - 1;
    };
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0})
            for (int i = 0; i < n; ++i)
                for (int j = 0; j < n; ++j) {
                    const auto at = [&](int a, int b) {
                        Vector3 p;
                        p[axis] = side;
                        p[(axis + 1) % 3] = 2.0 * a / n - 1.0;
                        p[(axis + 2) % 3] = 2.0 * b / n - 1.0;
                        return corner(p);
                    };
                    std::vector<int> face{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
                    if (side < 0.0)
                        std::reverse(face.begin(), face.end());
                    faces.push_back(face);
                }
    shapes::Random random(12);
    for (Vector3& p : points)
        p += bumps * random.vector();
    return shapes::mesh(points, faces);
}

GreenOptions patches(GreenOutside outside = GreenOutside::nearest, int exit_face = -1)
{
    return {cages::doubles, outside, exit_face, GreenFaces::quads};
}

SpaceTraits with_patches()
{
    const SurfaceMesh cage = quad_ball(2, 0.2);
    return {.name = "quads",
            .variants = {cages::variant<Green>("quads", cage, patches())},
            .control = cage.points(),
            .points = shapes::points_around(cage, 600, 1.0),
            .similarity = 1e-12,
            .follow = 3.0,
            .other = [cage] { return std::make_shared<Green>(Cage(cage), doubles()); }};
}

SpaceTraits with_both()
{
    SpaceTraits chosen = with_patches();
    const SurfaceMesh cage = shapes::u_prism(); // its ends are triangles, its sides quads
    chosen.name = "both";
    chosen.variants = {cages::variant<Green>("both", cage, patches(GreenOutside::refuse))};
    chosen.control = cage.points();
    chosen.points = cages::inside_u_prism(600, 1e-3);
    chosen.outside = Vector3(1.5, 2, 0.5);
    chosen.refuses_outside = true;
    chosen.other = [cage] { return std::make_shared<Green>(Cage(cage), doubles()); };
    return chosen;
}

SpaceTraits refusing()
{
    SpaceTraits chosen = traits();
    const SurfaceMesh cage = shapes::u_prism();
    chosen.name = "refusing";
    chosen.variants = {cages::variant<Green>("refusing", cage, doubles(GreenOutside::refuse))};
    chosen.points = cages::inside_u_prism(600, 1e-3);
    chosen.outside = Vector3(1.5, 2, 0.5);
    chosen.refuses_outside = true;
    return chosen;
}

} // namespace

// What its weights promise is in tests/bindings/spaces/test_cage_weights.py.
INSTANTIATE_TEST_SUITE_P(Green, SpaceContract,
                         testing::Values(traits(), refusing(), with_patches(), with_both()));

} // namespace sinew::test_green
