// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/multiresolution/details/deformation_transfer.h"

#include "native/operators/laplacian.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {

DeformationTransfer::DeformationTransfer(const SurfaceMesh& rest, const Regions& regions,
                                         std::shared_ptr<const RingRotations> rings)
    : rings_(std::move(rings)), still_(regions.handle_count(), Pose::Identity()),
      from_aims_(regions.handle_count(), true)
{
    for (const SoftConstraint& pulled : regions.soft())
        soft_.push_back(pulled.vertex);
    std::ranges::sort(soft_);
    soft_.erase(std::ranges::unique(soft_).begin(), soft_.end());
    const TriangleMetric metric = triangle_metric(rest);
    gradients_ = TurnedGradients(rest, metric);
    system_.factorize(std::make_shared<SparseMatrix>(laplacian_matrix(rest, Discretization::cotan, metric)),
                      regions);
}

void DeformationTransfer::apply(const Band& band, Points& detailed, SolveReport& /*report*/) const
{
    const auto work = workspaces_.take([] { return std::make_unique<Workspace>(); });
    // Held vertices have no details.
    work->aims = band.moved;
    for (int v : soft_)
        work->aims.row(v) +=
            (rings_->at(band.coarse, band.moved, v) * (band.fine.row(v) - band.coarse.row(v)).transpose())
                .transpose();
    const auto change = [&](int triangle, Vector3& first, Vector3& second) {
        const Triangle& corners = rings_->triangles()[triangle];
        const FaceMap map = face_map(band.coarse, band.moved, corners);
        Matrix3 T = -Matrix3::Identity();
        if (map.area > 0) {
            const double scale = std::sqrt(map.other_area / map.area);
            T += map.weighted / map.area + (scale - 1) * map.other_normal * map.normal.transpose();
        } else {
            T += rings_->at(band.coarse, band.moved, corners[0]);
        }
        first = (T * first).eval();
        second = (T * second).eval();
    };
    // The constraints have the displacements that lead from the fine shape to the aims.
    system_.solve({still_, view(work->aims), band.fine, &from_aims_}, detailed,
                  [&](RowMatrix& b) { return gradients_.source(band.fine, change, work->forces, b); });
}

void DeformationTransfer::report(BindReport& report) const { system_.report(report); }

} // namespace sinew
