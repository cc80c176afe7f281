// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/substeps.h"

#include "native/core/errors.h"
#include "native/handles/map_blend.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace sinew {

namespace {

constexpr double least_volume = 1e-9; ///< of a map, as a share of its size cubed, for it to have an inverse

} // namespace

Vector3 centre_of_handles(const Regions& regions, const PointsView& shape)
{
    Vector3 sum = Vector3::Zero();
    double count = 0.0;
    for (const Handle& handle : regions.handles())
        for (int v : handle.vertices) {
            sum += shape.row(v).transpose();
            ++count;
        }
    return sum / std::max(count, 1.0);
}

PathOfPoses::PathOfPoses(const Poses& poses, const Vector3& centre) : centre_(centre)
{
    for (const Pose& pose : poses) {
        const Polar polar(pose.leftCols<3>());
        const Vector3 turn = rotation_between(Eigen::Quaterniond::Identity(), Eigen::Quaterniond(polar.R));
        const double angle = turn.norm();
        const Vector3 axis = angle > 0 ? Vector3(turn / angle) : Vector3::UnitX(),
                      move = apply(pose, centre) - centre, along = move.dot(axis) * axis;
        ways_.push_back({axis, angle, polar.S, along, move - along});
    }
}

Poses PathOfPoses::at(double share) const
{
    Poses poses;
    for (const Way& way : ways_) {
        const auto turned = [&](double angle) {
            return Eigen::AngleAxisd(angle, way.axis).toRotationMatrix();
        };
        // The centre goes along an arc whose chord is `across`.
        const double half = 0.5 * way.angle,
                     chord = half > 0 ? std::sin(share * half) / std::sin(half) : share;
        const Vector3 move = share * way.along + chord * turned((share - 1) * half) * way.across;
        Pose pose;
        pose.leftCols<3>() =
            turned(share * way.angle) * (share * way.scale + (1 - share) * Matrix3::Identity());
        pose.col(3) = centre_ + move - pose.leftCols<3>() * centre_;
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
