// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/frames/principal_frame.h"

#include "native/core/dense.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace sinew {

namespace {

constexpr double equal = 0.02; ///< variances, as shares of the largest
constexpr double least_hint =
    0.1; ///< in the plane, as a share of half the longest side of the box around the points

/// The unit vector in the span of orthonormal columns that is nearest to x or y or z, tried in turn from
/// `first` on.
Vector3 nearest_axis(const Eigen::Matrix<double, 3, Eigen::Dynamic>& span, int first)
{
    Vector3 inside = Vector3::Zero();
    for (int k = 0; k < 3 && inside.norm() < 0.5; ++k) // one axis is always this near to a plane
        inside = span * span.row((first + k) % 3).transpose();
    return inside.normalized();
}

} // namespace

PrincipalFrame principal_frame(const Points& points, const std::vector<int>& vertices, const Vector3& hint)
{
    PrincipalFrame frame;
    for (int v : vertices)
        frame.centre += points.row(v).transpose();
    frame.centre /= static_cast<double>(vertices.size());
    double size = 0.0;
    for (int v : vertices)
        size = std::max(size, (points.row(v).transpose() - frame.centre).cwiseAbs().maxCoeff());
    Matrix3 spread = Matrix3::Zero();
    for (int v : vertices) {
        const Vector3 arm = (points.row(v).transpose() - frame.centre) / (size > 0 ? size : 1.0);
        spread += arm * arm.transpose();
    }
    const auto [values, vectors] = eigenvectors(spread); // rising
    const double most = equal * values[2];
    const int flat = values[1] - values[0] > most ? 1 : values[2] - values[0] > most ? 2 : 3;
    const Vector3 normal = flat == 1 ? Vector3(vectors.col(0)) : nearest_axis(vectors.leftCols(flat), 2);
    Vector3 first = vectors.col(2);
    if (values[2] - values[1] <= most) { // any direction in the plane
        Eigen::Matrix<double, 3, Eigen::Dynamic> plane(3, 2);
        plane.col(0) = normal.unitOrthogonal();
        plane.col(1) = normal.cross(Vector3(plane.col(0)));
        const Vector3 inside = plane * (plane.transpose() * hint);
        first = inside.norm() > least_hint * size ? inside.normalized() : nearest_axis(plane, 0);
    }
    frame.axes << first, normal.cross(first), normal;
    return frame;
}

} // namespace sinew
