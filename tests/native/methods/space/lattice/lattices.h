// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/lattice/ffd.h"
#include "tests/native/shapes.h"

#include <array>

/// Lattices that the tests share.
namespace sinew::lattices {

using Counts = std::array<int, 3>;

/// Points of a box, in Blender's order: the first axis first.
inline Points box(const Counts& n, const Vector3& low = {0, 0, 0}, const Vector3& high = {1, 1, 1})
{
    Points points(n[0] * n[1] * n[2], 3);
    for (int k = 0, row = 0; k < n[2]; ++k)
        for (int j = 0; j < n[1]; ++j)
            for (int i = 0; i < n[0]; ++i, ++row) {
                const Vector3 share(n[0] > 1 ? i / (n[0] - 1.0) : 0.5, n[1] > 1 ? j / (n[1] - 1.0) : 0.5,
                                    n[2] > 1 ? k / (n[2] - 1.0) : 0.5);
                points.row(row) = (low + share.cwiseProduct(high - low)).transpose();
            }
    return points;
}

/// The same bent a little, as no affine map does.
inline Points bent(Points points, double by = 0.15)
{
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const Vector3 p = points.row(i).transpose();
        points.row(i) += by * Eigen::RowVector3d(p.y() * p.z(), p.x() * p.x(), std::sin(2 * p.x()));
    }
    return points;
}

inline RestGridOptions options(LatticeBasis basis, int degree = 3)
{
    RestGridOptions found;
    found.basis.fill(basis);
    found.degree = degree;
    return found;
}

inline Points in_box(int count, const Vector3& low, const Vector3& high, std::uint64_t seed = 1)
{
    shapes::Random random(seed);
    Points points(count, 3);
    for (int i = 0; i < count; ++i)
        for (int axis = 0; axis < 3; ++axis)
            points(i, axis) = low[axis] + random.unit() * (high[axis] - low[axis]);
    return points;
}

/// Boxes side by side as one mesh of quads, with the faces between them.
inline SurfaceMesh boxes(const Counts& cells, const Vector3& low = {0, 0, 0}, const Vector3& high = {1, 1, 1})
{
    const Counts n{cells[0] + 1, cells[1] + 1, cells[2] + 1};
    const auto at = [&](int i, int j, int k) { return i + n[0] * (j + n[1] * k); };
    shapes::Polygons faces;
    for (int k = 0; k < n[2]; ++k)
        for (int j = 0; j < n[1]; ++j)
            for (int i = 0; i < n[0]; ++i) {
                if (j < cells[1] && k < cells[2])
                    faces.push_back({at(i, j, k), at(i, j + 1, k), at(i, j + 1, k + 1), at(i, j, k + 1)});
                if (i < cells[0] && k < cells[2])
                    faces.push_back({at(i, j, k), at(i + 1, j, k), at(i + 1, j, k + 1), at(i, j, k + 1)});
                if (i < cells[0] && j < cells[1])
                    faces.push_back({at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k), at(i, j + 1, k)});
            }
    return shapes::over(box(n, low, high), faces);
}

} // namespace sinew::lattices
