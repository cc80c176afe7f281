// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/trees/winding_tree.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>

namespace sinew {

namespace {

constexpr int leaf = 8;
constexpr double far = 4.0; ///< in radii of a group

Vector3 centroid(const Corners& t) { return (t[0] + t[1] + t[2]) / 3; }
Vector3 area_vector(const Corners& t) { return 0.5 * (t[1] - t[0]).cross(t[2] - t[0]); }

/// atan2(y, x) to 2 units in the last place, for finite numbers; 0 where both are 0. As in lane_math.inl it
/// has the same bits on every machine. Those of C libraries differ in the last bit.
double angle(double y, double x)
{
    const double flat = std::abs(x), high = std::abs(y);
    const bool steep = high > 2.4142135623730951 * flat, oblique = high > 0.41421356237309503 * flat;
    const double top = steep ? -flat : oblique ? high - flat : high;
    const double bottom = steep ? high : oblique ? high + flat : flat;
    const double base = steep ? 1.5707963267948966 : oblique ? 0.78539816339744831 : 0.0;
    const double t = top / std::max(bottom, 1e-300), u = t * t, u2 = u * u, u4 = u2 * u2;
    // The polynomial interpolates (atan(t) / t - 1) / t^2 at Chebyshev points of |t| <= tan(pi / 8).
    const double low = (-0.3333333333333333 + 0.1999999999999552 * u) +
                       (-0.14285714284666542 + 0.11111111015256361 * u) * u2;
    const double middle = (-0.09090904578123903 + 0.07692183190826087 * u) +
                          (-0.06664511447381948 + 0.0585814891280221 * u) * u2;
    const double last = (-0.0508544973794026 + 0.03923165829558719 * u) + -0.01917688711906226 * u2;
    const double found = base + (t + t * (u * (low + (middle + last * u4) * u4)));
    return std::copysign(x < 0.0 ? std::numbers::pi - found : found, y);
}

} // namespace

double solid_angle(const Corners& triangle, const Vector3& at)
{
    // A. van Oosterom, J. Strackee 1983
    const Vector3 a = triangle[0] - at, b = triangle[1] - at, c = triangle[2] - at;
    const double u = a.norm(), v = b.norm(), w = c.norm();
    return 2 * angle(a.dot(b.cross(c)), u * v * w + a.dot(b) * w + b.dot(c) * u + c.dot(a) * v);
}

WindingTree::WindingTree(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles)
{
    for (const Triangle& t : triangles)
        triangles_.push_back(corners_of(points, t));
    nodes_.reserve(triangles_.size());
    if (!triangles_.empty())
        build(0, static_cast<int>(triangles_.size()));
}

void WindingTree::build(int begin, int end)
{
    const std::size_t own = nodes_.size();
    Eigen::AlignedBox3d centroids;
    Vector3 weighted = Vector3::Zero(), normal = Vector3::Zero();
    double area = 0.0;
    for (int t = begin; t < end; ++t) {
        const Vector3 c = centroid(triangles_[t]), n = area_vector(triangles_[t]);
        centroids.extend(c);
        normal += n;
        weighted += n.norm() * c;
        area += n.norm();
    }
    const Vector3 centre = area > 0 ? Vector3(weighted / area) : centroids.center();
    Matrix3 moment = Matrix3::Zero();
    double square = 0.0;
    for (int t = begin; t < end; ++t) {
        moment += area_vector(triangles_[t]) * (centroid(triangles_[t]) - centre).transpose();
        for (const Vector3& corner : triangles_[t])
            square = std::max(square, (corner - centre).squaredNorm());
    }
    nodes_.push_back({centre, std::sqrt(square), normal, moment, begin, end});
    if (end - begin <= leaf)
        return;
    Eigen::Index axis = 0;
    centroids.sizes().maxCoeff(&axis);
    const int middle = begin + (end - begin) / 2;
    const auto place = [axis](const Corners& corners) {
        const Vector3 at = centroid(corners);
        return std::tuple(at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]);
    };
    std::ranges::nth_element(triangles_.begin() + begin, triangles_.begin() + middle,
                             triangles_.begin() + end, {}, place);
    build(begin, middle);
    nodes_[own].second = static_cast<int>(nodes_.size());
    build(middle, end);
}

double WindingTree::at(const Vector3& point) const
{
    double sum = 0.0; // of solid angles
    std::array<int, 64> open{};
    int count = nodes_.empty() ? 0 : 1;
    while (count > 0) {
        const int number = open[--count];
        const Node& node = nodes_[number];
        const Vector3 r = node.centre - point;
        const double square = r.squaredNorm();
        if (square > far * far * node.radius * node.radius) {
            const double distance = std::sqrt(square);
            const Vector3 u = r / distance;
            sum +=
                (node.normal.dot(u) + (node.moment.trace() - 3 * u.dot(node.moment * u)) / distance) / square;
        } else if (node.second == 0) {
            for (int t = node.begin; t < node.end; ++t)
                sum += solid_angle(triangles_[t], point);
        } else {
            open[count++] = node.second;
            open[count++] = number + 1;
        }
    }
    return sum / (4 * std::numbers::pi);
}

} // namespace sinew
