// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

/// Meshes, handles and poses that the tests share.
namespace sinew::shapes {

using Polygons = std::vector<std::vector<int>>;

inline constexpr double pi = std::numbers::pi;

/// The same numbers on every standard library.
class Random
{
public:
    explicit Random(std::uint64_t seed) : state_(seed * 2862933555777941757ULL + 3037000493ULL) {}

    std::uint64_t bits()
    {
        state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
        const std::uint64_t x = (state_ ^ (state_ >> 33)) * 0xff51afd7ed558ccdULL;
        return x ^ (x >> 33);
    }
    /// In [-1, 1).
    double signed_unit() { return 2 * unit() - 1; }
    /// In [0, 1).
    double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
    int below(int bound) { return static_cast<int>(bits() % static_cast<std::uint64_t>(bound)); }
    Vector3 vector();
    Matrix3 matrix() { return dense(3, 3); }
    Matrix3 rotation();
    MatrixX dense(int rows, int columns);
    /// 0 to count - 1 in another order.
    std::vector<int> shuffled(int count);
    /// In a box of this reach to all sides.
    Points points(int count, double reach = 1.0);
    /// Each point moved by up to `by` along each axis.
    Points shaken(Points points, double by);

private:
    std::uint64_t state_;
};

Points points_of(const std::vector<Vector3>& list);

std::vector<Vector3> list_of(const Points& points);

/// From `begin` on, below `end`.
std::vector<int> numbers(int begin, int end);

SurfaceMesh over(const Points& points, const Polygons& faces);

SurfaceMesh mesh(const std::vector<Vector3>& points, const Polygons& faces);

Polygons faces_of(const SurfaceMesh& of);

/// The same faces over other points.
SurfaceMesh moved(const SurfaceMesh& of, const Points& points);

/// Some faces turned round.
SurfaceMesh flipped(const SurfaceMesh& of, const std::vector<int>& faces);

/// All of them.
SurfaceMesh inside_out(const SurfaceMesh& of);

SurfaceMesh without_face(const SurfaceMesh& of, int face);

/// +x -x +y -y +z -z, corners at distance 1.
SurfaceMesh octahedron();

/// Unit cube of six quads, outward.
SurfaceMesh cube();

/// (columns + 1) x (rows + 1) vertices of the plane z = 0, row by row, inner ones moved by up
/// to `jitter` of the spacing.
Points grid_points(int columns, int rows, double spacing = 1.0, double jitter = 0.0);

SurfaceMesh quad_grid(int columns, int rows, double spacing = 1.0);

SurfaceMesh grid(int columns, int rows, double spacing = 1.0, double jitter = 0.0);

/// A grid over a smooth hill: curved, open, no symmetry.
SurfaceMesh hill(int columns, int rows);

/// The octahedron refined `level` times onto the unit sphere: 4^(level + 1) + 2 vertices.
SurfaceMesh sphere(int level);

/// A closed bar along x of quads, `across` on each short side; cells are unit cubes' sides.
SurfaceMesh bar(int along, int across);

/// A hill with a doubled face, a face without area, a needle, a face with a corner twice, a fin
/// on an inner edge, a part of its own and a loose vertex.
SurfaceMesh messy();

/// Both meshes in one, the second after the first and moved by `offset`.
SurfaceMesh joined(const SurfaceMesh& first, const SurfaceMesh& second, const Vector3& offset);

/// Vertices for which `chosen(point)` holds.
template <class Choice>
std::vector<int> where(const SurfaceMesh& of, Choice&& chosen)
{
    std::vector<int> result;
    for (int i = 0; i < of.vertex_count(); ++i)
        if (chosen(of.point(i)))
            result.push_back(i);
    return result;
}

/// Both ends along x, each `depth` deep.
std::vector<Handle> ends(const SurfaceMesh& of, double depth);

Pose still();

Pose affine(const Matrix3& linear, const Vector3& move = Vector3::Zero());

Pose shift(double x, double y, double z);

Matrix3 rotation(const Vector3& axis, double degrees);

/// Rotation about an axis through `centre`, then a translation.
Pose turn(const Vector3& axis, double degrees, const Vector3& centre = Vector3::Zero(),
          const Vector3& move = Vector3::Zero());

Points transformed(const Points& points, const Pose& pose);

/// Largest distance between corresponding points.
double distance(const Points& a, const Points& b);

/// Diagonal of the bounding box.
double size(const Points& points);

} // namespace sinew::shapes
