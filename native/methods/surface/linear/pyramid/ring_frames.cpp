// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/pyramid/ring_frames.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <cmath>

namespace sinew {

namespace {

/// Tangents span a plane if their parallelogram has at least this share of the square of their lengths.
constexpr double least_spread = 1e-8;

} // namespace

Matrix3 RingFrames::at(int which, int vertex, const Points& points, const Matrix3& fallback) const
{
    Vector3 u = Vector3::Zero(), v = Vector3::Zero();
    const Vector3 own = points.row(vertex).transpose();
    for (int k = offsets_[which]; k < offsets_[which + 1]; ++k) {
        const Vector3 edge = points.row(neighbours_[k].vertex).transpose() - own;
        u += neighbours_[k].a * edge;
        v += neighbours_[k].b * edge;
    }
    const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v);
    const Vector3 across = u.cross(v);
    const double area = across.norm(); // the root of the determinant of the inner products
    if (!(area > least_spread * (uu + vv)))
        return fallback;
    // The root of a symmetric matrix S of two rows is (S + sqrt(det S)) / sqrt(tr S + 2 sqrt(det S)); its
    // determinant is that of the root of S.
    const double scale = 1.0 / (std::sqrt(uu + vv + 2 * area) * area);
    Matrix3 frame;
    frame << scale * ((vv + area) * u - uv * v), scale * ((uu + area) * v - uv * u), across / area;
    return frame;
}

std::vector<RingFrames::Neighbour> fitted_tangents(const Points& rest, int vertex,
                                                   std::span<const int> around, const Vector3& normal)
{
    std::vector<RingFrames::Neighbour> numbers;
    for (int j : around)
        numbers.push_back({j, 0.0, 0.0});
    if (!(normal.norm() > 0))
        return numbers;
    const Vector3 n = normal.normalized(), u = n.unitOrthogonal(), v = n.cross(u);
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    for (RingFrames::Neighbour& each : numbers) {
        const Vector3 edge = (rest.row(each.vertex) - rest.row(vertex)).transpose();
        each.a = u.dot(edge);
        each.b = v.dot(edge);
        spread += Eigen::Vector2d(each.a, each.b) * Eigen::Vector2d(each.a, each.b).transpose();
    }
    const double trace = spread.trace();
    const bool flat = !(spread.determinant() > least_spread * trace * trace);
    const Eigen::Matrix2d inverse = flat ? Eigen::Matrix2d::Zero() : Eigen::Matrix2d(spread.inverse());
    for (RingFrames::Neighbour& each : numbers) {
        const Eigen::Vector2d number = inverse * Eigen::Vector2d(each.a, each.b);
        each.a = number.x();
        each.b = number.y();
    }
    return numbers;
}

} // namespace sinew
