// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/space/cage/cage.h"
#include "native/space/cage/inside/outside_weights.h"
#include "native/space/cage/mean_value.h"
#include "native/space/method.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"
#include "tests/native/space/contract.h"

#include <cmath>

namespace sinew {

/// Where a posed control takes the bound points.
inline Points warped_by(const SpaceMethod& method, PointsView control,
                        const std::optional<PointsView>& incoming = {})
{
    Points out(method.points().rows(), 3);
    method.warp(control, incoming, out.data());
    return out;
}

} // namespace sinew

/// Cages and points that the tests of cage coordinates share.
namespace sinew::shapes {

/// A prism over a U, with n-gons at both ends: at (.5, 2.5, .5) one arm does not see the other's inner side.
inline SurfaceMesh u_prism()
{
    const std::vector<Vector3> outline{{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {2, 3, 0},
                                       {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
    std::vector<Vector3> p = outline;
    for (const Vector3& low : outline)
        p.push_back(low + Vector3(0, 0, 1));
    Polygons faces{{7, 6, 5, 4, 3, 2, 1, 0}, {8, 9, 10, 11, 12, 13, 14, 15}};
    for (int i = 0; i < 8; ++i)
        faces.push_back({i, (i + 1) % 8, 8 + (i + 1) % 8, 8 + i});
    return mesh(p, faces);
}

/// A sphere of triangles with bumps, no two planes or lengths the same.
inline SurfaceMesh bumpy_sphere(int level, double bumps = 0.1)
{
    const SurfaceMesh round = sphere(level);
    Points p = round.points();
    Random random(11);
    for (Eigen::Index i = 0; i < p.rows(); ++i)
        p.row(i) += bumps * random.vector().transpose();
    return moved(round, p);
}

/// In a box around the middle, `reach` times as large as the cage's.
inline Points points_around(const SurfaceMesh& cage, int count, double reach, std::uint64_t seed = 1)
{
    const Eigen::RowVector3d low = cage.points().colwise().minCoeff(),
                             high = cage.points().colwise().maxCoeff();
    Random random(seed);
    Points p(count, 3);
    for (int i = 0; i < count; ++i)
        p.row(i) = 0.5 * (low + high) + 0.5 * reach * (high - low).cwiseProduct(random.vector().transpose());
    return p;
}

/// On and around every vertex, the edges and the faces, at the given distances to both sides.
inline Points points_near(const SurfaceMesh& cage, const std::vector<double>& distances)
{
    Random random(3);
    std::vector<Vector3> p;
    for (const Triangle& t : cage.triangles()) {
        const Vector3 a = cage.point(t[0]), b = cage.point(t[1]), c = cage.point(t[2]);
        const Vector3 normal = (b - a).cross(c - a).normalized();
        const double s = 0.1 + 0.8 * random.unit(), r = 0.1 + 0.8 * random.unit();
        for (const double d : distances) {
            const Vector3 away = d * (normal + 0.3 * random.vector());
            for (const double side : {-1.0, 1.0}) {
                p.push_back(a + side * away);
                p.push_back(a + s * (b - a) + side * away);
                p.push_back(a + s * (r * b + (1 - r) * c - a) + side * away);
                p.push_back(a + (1 + s) * (b - a) + side * away); // beyond an edge, on its line
                p.push_back(a + (1 + s) * (b - a) + r * (c - a) +
                            side * away); // beyond the triangle, in its plane
            }
        }
    }
    return points_of(p);
}

} // namespace sinew::shapes

namespace sinew::cages {

using shapes::u_prism;

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

inline Points in_cube(int count, double depth = 0.0)
{
    shapes::Random random(1);
    Points points(count, 3);
    for (Eigen::Index k = 0; k < points.size(); ++k)
        points.data()[k] = depth + (1 - 2 * depth) * random.unit();
    return points;
}

/// The unit cube, its top of two triangles of which one has no area.
inline SurfaceMesh cube_with_a_flat_triangle()
{
    Points p = shapes::cube().points();
    shapes::Polygons faces = shapes::faces_of(shapes::cube());
    faces[1] = {4, 5, 6};
    faces.push_back({4, 6, 7});
    p.row(5) = 0.5 * (p.row(4) + p.row(6));
    return shapes::over(p, faces);
}

inline constexpr PointWeightOptions doubles{WeightPrecision::double_precision, 0.0};

template <class Method, class Options>
RowMatrix weights(const SurfaceMesh& cage, const Points& points, const Options& options)
{
    Method coordinates(Cage(cage), options);
    coordinates.bind(view(points));
    return coordinates.weights().dense();
}

inline double largest(const RowMatrix& matrix) { return matrix.cwiseAbs().maxCoeff(); }

/// Sum, sign, and linear precision to a share of the cage's size.
inline void expect_barycentric(const RowMatrix& w, const SurfaceMesh& cage, const Points& points,
                               double precision)
{
    EXPECT_LT((w.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
    EXPECT_LT(largest(w * cage.points() - points), precision * shapes::size(cage.points()));
    EXPECT_GE(w.minCoeff(), 0);
}

/// These points are refused and named, or bound by mean values where that is asked for.
template <class Method, class Options>
void expect_outside(const SurfaceMesh& cage, Options options, const Points& points,
                    const std::vector<int>& outside)
{
    expect_elements(refusal<InvalidConstraint>([&] { weights<Method>(cage, points, options); }),
                    Error::Element::vertex, outside);
    options.outside = CageOutside::mean_value;
    Method both(Cage(cage), options);
    EXPECT_EQ(both.bind(view(points)).outside, outside);
    const RowMatrix w = both.weights().dense(), plain = weights<MeanValue>(cage, points, doubles);
    for (int i : outside)
        EXPECT_LT((w.row(i) - plain.row(i)).norm(), 1e-12) << i;
}

/// One set of options of a cage method.
template <class Method, class Options>
SpaceVariant variant(const std::string& name, const SurfaceMesh& cage, const Options& options)
{
    return {name, [cage, options] { return std::make_shared<Method>(Cage(cage), options); }};
}

} // namespace sinew::cages
