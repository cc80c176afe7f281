// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "tests/native/shapes.h"

#include <cmath>

/// Cages and points that the tests of cage methods share.
namespace sinew::cages {

/// A U of three arms' width and height and of depth 1, its caps of eight corners and its sides quads.
inline SurfaceMesh u_prism()
{
    const std::vector<std::array<double, 2>> outline{{0, 0}, {3, 0}, {3, 3}, {2, 3},
                                                     {2, 1}, {1, 1}, {1, 3}, {0, 3}};
    std::vector<Vector3> points;
    for (double z : {0.0, 1.0})
        for (const auto& [x, y] : outline)
            points.emplace_back(x, y, z);
    shapes::Polygons faces{{7, 6, 5, 4, 3, 2, 1, 0}, {8, 9, 10, 11, 12, 13, 14, 15}};
    for (int i = 0; i < 8; ++i) {
        const int j = (i + 1) % 8;
        faces.push_back({i, j, 8 + j, 8 + i});
    }
    return shapes::mesh(points, faces);
}

/// Whether a point lies in it, at least `depth` from its surface.
inline bool in_u_prism(const Vector3& p, double depth)
{
    const bool box = p.minCoeff() > depth && p.x() < 3 - depth && p.y() < 3 - depth && p.z() < 1 - depth;
    return box && !(p.x() > 1 - depth && p.x() < 2 + depth && p.y() > 1 - depth);
}

inline Points inside_u_prism(int count, double depth, std::uint64_t seed = 1)
{
    shapes::Random random(seed);
    Points points(count, 3);
    for (int i = 0; i < count;) {
        const Vector3 p(3 * random.unit(), 3 * random.unit(), random.unit());
        if (in_u_prism(p, depth))
            points.row(i++) = p.transpose();
    }
    return points;
}

/// A sphere of triangles whose radius is anything from `low` to 1: concave, and no two edges alike.
inline SurfaceMesh bumpy(int level, double low, std::uint64_t seed)
{
    const SurfaceMesh sphere = shapes::sphere(level);
    shapes::Random random(seed);
    Points points = sphere.points();
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        points.row(i) *= low + (1 - low) * random.unit();
    return shapes::moved(sphere, points);
}

/// Points within a ball.
inline Points in_ball(int count, double radius, std::uint64_t seed = 1)
{
    shapes::Random random(seed);
    Points points(count, 3);
    for (int i = 0; i < count;) {
        const Vector3 p = radius * random.vector();
        if (p.norm() < radius)
            points.row(i++) = p.transpose();
    }
    return points;
}

} // namespace sinew::cages
