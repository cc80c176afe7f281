// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/frames/normal_frame.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {

namespace {

constexpr double ordinary = 1e5; ///< the largest size that is left as it is, and one over the smallest
constexpr double near = 256.0; ///< the largest distance from the origin that is left as it is, in sizes
constexpr double farthest = 1e30;
constexpr double least = 1e-150;

SurfaceMesh over(Points points, const SurfaceMesh& mesh)
{
    std::vector<int> counts, corners;
    for (int f = 0; f < mesh.face_count(); ++f) {
        counts.push_back(static_cast<int>(mesh.face(f).size()));
        corners.insert(corners.end(), mesh.face(f).begin(), mesh.face(f).end());
    }
    return {std::move(points), std::move(counts), std::move(corners)};
}

} // namespace

double normal_unit(const Points& points)
{
    const double size = (points.colwise().maxCoeff() - points.colwise().minCoeff()).maxCoeff();
    const bool as_it_is = !(size > 0.0) || (size >= 1.0 / ordinary && size <= ordinary);
    return as_it_is ? 1.0 : std::ldexp(1.0, std::ilogb(size));
}

std::optional<SurfaceMesh> in_unit(const SurfaceMesh& mesh, double unit)
{
    if (unit == 1.0)
        return {};
    return over(mesh.points() / unit, mesh);
}

std::vector<Vector3> points_in_unit(const PointsView& points, double unit)
{
    std::vector<Vector3> all;
    all.reserve(static_cast<std::size_t>(points.rows()));
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        all.emplace_back((points.row(i).transpose() / unit).unaryExpr([](double x) {
            return std::abs(x) < least ? 0.0 : std::clamp(x, -farthest, farthest);
        }));
    return all;
}

NormalFrame::NormalFrame(const Points& points) : unit_(normal_unit(points))
{
    const Eigen::RowVector3d low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
    const double size = (high - low).maxCoeff();
    const Vector3 middle = (low + 0.5 * (high - low)).transpose();
    if (unit_ != 1.0 || middle.cwiseAbs().maxCoeff() > near * size)
        middle_ = middle;
}

Vector3 NormalFrame::in(const Vector3& point) const
{
    const double most = point.cwiseAbs().maxCoeff();
    const Vector3 within = most > farthest * unit_ ? Vector3(point / most * (farthest * unit_)) : point;
    return (within - middle_) / unit_;
}

PointsView NormalFrame::in(PointsView points, Points& storage) const
{
    if (points.rows() == 0 || (is_identity() && points.cwiseAbs().maxCoeff() <= farthest))
        return points;
    storage.resize(points.rows(), 3);
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        storage.row(i) = in(points.row(i).transpose()).transpose();
    return view(storage);
}

SurfaceMesh NormalFrame::in(const SurfaceMesh& mesh) const
{
    if (is_identity())
        return mesh;
    Points points;
    in(view(mesh.points()), points);
    return over(std::move(points), mesh);
}

} // namespace sinew
