// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/multiresolution/details/deformation_transfer.h"

#include "native/operators/laplacian.h"
#include "native/operators/rotation_fit.h"

#include <cmath>
#include <utility>

namespace sinew {

DeformationTransfer::DeformationTransfer(const SurfaceMesh& rest, const Regions& regions,
                                         std::shared_ptr<const RingRotations> rings)
    : rings_(std::move(rings)), still_(regions.handle_count(), Pose::Identity()),
      from_aims_(regions.handle_count(), true)
{
    const TriangleMetric metric = triangle_metric(rest);
    gradients_ = TurnedGradients(rest, metric);
    system_.factorize(std::make_shared<SparseMatrix>(laplacian_matrix(rest, Discretization::cotan, metric)),
                      regions);
}

Matrix3 DeformationTransfer::map_of(int triangle, const Band& band, const std::vector<Matrix3>& maps) const
{
    const Triangle& corners = rings_->triangles()[triangle];
    const FaceMap map = face_map(band.coarse, band.moved, corners);
    if (map.area > 0) {
        const double scale = std::sqrt(map.other_area / map.area);
        return map.weighted / map.area + (scale - 1) * map.other_normal * map.normal.transpose();
    }
    Matrix3 around = Matrix3::Zero();
    for (int v : corners)
        for (int t : rings_->around(v))
            around += maps[t];
    return fit_rotation(around);
}

void DeformationTransfer::apply(const Band& band, Points& detailed, SolveReport& /*report*/) const
{
    const auto work = workspaces_.take([] { return std::make_unique<Workspace>(); });
    work->aims = band.moved;
    rings_->fit(
        band.coarse, band.moved, work->maps, [&](int v) { return band.fine.row(v) != band.coarse.row(v); },
        [&](int v, const Matrix3& R) {
            work->aims.row(v) += (R * (band.fine.row(v) - band.coarse.row(v)).transpose()).transpose();
        });
    const auto change = [&](int triangle, Vector3& first, Vector3& second) {
        const Matrix3 T = map_of(triangle, band, work->maps) - Matrix3::Identity();
        first = (T * first).eval();
        second = (T * second).eval();
    };
    // Held vertices have the displacements that lead from the fine shape to the aims.
    system_.solve({still_, view(work->aims), band.fine, &from_aims_}, detailed,
                  [&](RowMatrix& b) { return gradients_.source(band.fine, change, work->forces, b); });
}

void DeformationTransfer::report(BindReport& report) const { system_.report(report); }

} // namespace sinew
