// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/substeps.h"

#include "native/core/errors.h"
#include "native/handles/map_blend.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <cmath>
#include <string>
#include <utility>

namespace sinew {

namespace {

constexpr double least_volume = 1e-9; ///< of a map, as a share of its size cubed, for it to have an inverse

} // namespace

std::vector<Vector3> handle_centres(const Regions& regions, const PointsView& shape)
{
    std::vector<Vector3> centres;
    for (const Handle& handle : regions.handles()) {
        Vector3 sum = Vector3::Zero();
        for (int v : handle.vertices)
            sum += shape.row(v).transpose();
        centres.emplace_back(sum / static_cast<double>(handle.vertices.size()));
    }
    return centres;
}

PathOfPoses::PathOfPoses(const Poses& poses, std::vector<Vector3> centres)
{
    for (std::size_t h = 0; h < poses.size(); ++h) {
        const Polar polar(poses[h].leftCols<3>());
        ways_.push_back({rotation_between(Eigen::Quaterniond::Identity(), Eigen::Quaterniond(polar.R)),
                         polar.S, centres[h], apply(poses[h], centres[h])});
    }
}

Poses PathOfPoses::at(double share) const
{
    Poses poses;
    for (const Way& way : ways_) {
        Pose pose;
        const double angle = way.turn.norm();
        const Eigen::AngleAxisd turn(share * angle, angle > 0 ? Vector3(way.turn / angle) : Vector3::UnitX());
        pose.leftCols<3>() =
            turn.toRotationMatrix() * (share * way.scale + (1 - share) * Matrix3::Identity());
        pose.col(3) = way.from + share * (way.to - way.from) - pose.leftCols<3>() * way.from;
        poses.push_back(pose);
    }
    return poses;
}

SurfaceMesh with_points(const SurfaceMesh& mesh, const Points& points)
{
    std::vector<int> counts, corners;
    for (int f = 0; f < mesh.face_count(); ++f) {
        const auto face = mesh.face(f);
        counts.push_back(static_cast<int>(face.size()));
        corners.insert(corners.end(), face.begin(), face.end());
    }
    return {points, std::move(counts), std::move(corners)};
}

Poses relative_poses(const Poses& before, const Poses& after)
{
    Poses poses;
    for (std::size_t h = 0; h < before.size(); ++h) {
        const Matrix3 map = before[h].leftCols<3>();
        if (!(std::abs(map.determinant()) > least_volume * std::pow(map.norm(), 3)))
            throw InvalidConstraint("handle " + std::to_string(h) +
                                        " is flat in the middle of the substeps: use one step, or turn the "
                                        "handle instead of mirroring it",
                                    Error::Element::handle, {static_cast<int>(h)});
        Pose pose;
        pose.leftCols<3>() = after[h].leftCols<3>() * map.inverse();
        pose.col(3) = after[h].col(3) - pose.leftCols<3>() * before[h].col(3);
        poses.push_back(pose);
    }
    return poses;
}

} // namespace sinew
