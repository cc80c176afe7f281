// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/transfer/mesh_transfer.h"

#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/mesh/regions.h"
#include "native/mesh/same_faces.h"
#include "native/operators/fits/rotation_fit.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

namespace sinew {

namespace {

/// (k) the centres of the parts.
Points centres(const PointsView& points, const Components& parts, const VectorX& shares)
{
    Points found = Points::Zero(parts.count, 3);
    for (int v = 0; v < points.rows(); ++v)
        found.row(parts.labels[v]) += shares[v] * points.row(v);
    return found;
}

/// (n) the share of each vertex in the area of its part, and the area of the whole. Where a part has no area,
/// all of its vertices have the same share.
std::pair<VectorX, double> shares_of(const SurfaceMesh& mesh, const Components& parts)
{
    VectorX area = VectorX::Zero(mesh.vertex_count());
    for (const Triangle& t : mesh.triangles()) {
        const Vector3 a = mesh.point(t[1]) - mesh.point(t[0]), b = mesh.point(t[2]) - mesh.point(t[0]);
        for (int v : t)
            area[v] += a.cross(b).norm() / 6;
    }
    VectorX sums = VectorX::Zero(parts.count), counts = sums;
    for (int v = 0; v < area.size(); ++v) {
        sums[parts.labels[v]] += area[v];
        counts[parts.labels[v]] += 1;
    }
    const double whole = area.sum();
    for (int v = 0; v < area.size(); ++v) {
        const int part = parts.labels[v];
        area[v] = sums[part] > 0 ? area[v] / sums[part] : 1 / counts[part];
    }
    return {std::move(area), whole};
}

/// One vertex of each part.
Regions anchors(const Components& parts)
{
    Handle handle;
    for (int v = 0; v < static_cast<int>(parts.labels.size()); ++v)
        if (parts.labels[v] == static_cast<int>(handle.vertices.size()))
            handle.vertices.push_back(v);
    return {{std::move(handle)}, parts};
}

} // namespace

MeshTransfer::MeshTransfer(const SurfaceMesh& source, const SurfaceMesh& target)
    : source_(source.points()), target_(target.points()), parts_(connected_components(target))
{
    require_same_faces(source, target);
    rings_ = std::make_shared<const RingRotations>(target);
    faces_ =
        std::make_unique<DeformationTransfer>(target, anchors(parts_), view(target_), view(source_), rings_);
    double area = 0.0, target_area = 0.0;
    std::tie(shares_, area) = shares_of(source, parts_);
    std::tie(target_shares_, target_area) = shares_of(target, parts_);
    if (area > 0 && target_area > 0)
        scale_ = std::sqrt(target_area / area);
    centres_ = centres(view(source_), parts_, shares_);
    target_centres_ = centres(view(target_), parts_, target_shares_);
}

void MeshTransfer::transfer(const PointsView& source, Points& target) const
{
    if (source.rows() != source_.rows())
        throw InvalidConstraint("source: " + std::to_string(source.rows()) +
                                " points given for a rest shape of " + std::to_string(source_.rows()));
    if (!all_finite(source))
        throw InvalidConstraint("source: NaN or infinite coordinates");
    SolveReport report;
    faces_->apply({view(target_), view(source_), source, true}, target, report);
    Matrix3 sum = Matrix3::Zero();
    for (const Triangle& t : rings_->triangles())
        sum += face_map(view(source_), source, t).weighted;
    const Matrix3 Q = fit_rotation(sum);
    const Points goal = target_centres_ * Q.transpose() +
                        scale_ * (centres(source, parts_, shares_) - centres_ * Q.transpose()),
                 moves = goal - centres(view(target), parts_, target_shares_);
    for (int v = 0; v < target.rows(); ++v)
        target.row(v) += moves.row(parts_.labels[v]);
}

} // namespace sinew
