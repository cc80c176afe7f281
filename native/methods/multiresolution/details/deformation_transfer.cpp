// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/details/deformation_transfer.h"

#include "native/core/parallel.h"
#include "native/operators/laplacian.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {

DeformationTransfer::DeformationTransfer(const SurfaceMesh& rest, const Regions& regions,
                                         const PointsView& fine, const PointsView& coarse,
                                         std::shared_ptr<const RingRotations> rings)
    : rings_(std::move(rings)), still_(regions.handle_count(), Pose::Identity()),
      from_aims_(regions.handle_count(), true), edges_(rest.triangles().size())
{
    for (const SoftConstraint& pulled : regions.soft())
        soft_.push_back(pulled.vertex);
    std::ranges::sort(soft_);
    soft_.erase(std::ranges::unique(soft_).begin(), soft_.end());
    const TriangleMetric metric = triangle_metric(rest);
    gradients_ = TurnedGradients(rest, metric);
    system_.factorize(std::make_shared<SparseMatrix>(laplacian_matrix(rest, Discretization::cotan, metric)),
                      regions);
    parallel_for(static_cast<int>(edges_.size()), [&](int t) { edges_[t] = edges_of(fine, coarse, t); });
}

DeformationTransfer::Edges DeformationTransfer::edges_of(const PointsView& fine, const PointsView& coarse,
                                                         int triangle) const
{
    const Triangle& t = rings_->triangles()[triangle];
    const FaceDual dual = face_dual(coarse, t);
    const double area = dual.normal.norm();
    if (area == 0.0)
        return {Vector3::Zero(), Vector3::Zero(), true};
    Matrix3 inverse;
    inverse << dual.first.transpose() / area, dual.second.transpose() / area,
        dual.normal.transpose() / (area * std::sqrt(2 * area));
    return {inverse * (fine.row(t[1]) - fine.row(t[0])).transpose(),
            inverse * (fine.row(t[2]) - fine.row(t[0])).transpose(), false};
}

void DeformationTransfer::apply(const Band& band, Points& detailed, SolveReport& /*report*/) const
{
    const auto work = workspaces_.take([] { return std::make_unique<Workspace>(); });
    if (!soft_.empty()) { // held vertices have no details
        work->aims = band.moved;
        for (int v : soft_)
            work->aims.row(v) +=
                (rings_->at(band.coarse, band.moved, v) * (band.fine.row(v) - band.coarse.row(v)).transpose())
                    .transpose();
    }
    const auto change = [&](int triangle, Vector3& first, Vector3& second) {
        const auto [i, j, k] = rings_->triangles()[triangle];
        const Edges edges = band.at_rest ? edges_[triangle] : edges_of(band.fine, band.coarse, triangle);
        if (edges.flat) {
            const Matrix3 R = rings_->at(band.coarse, band.moved, i);
            first = (R * first - first).eval();
            second = (R * second - second).eval();
            return;
        }
        const Vector3 f1 = (band.moved.row(j) - band.moved.row(i)).transpose(),
                      f2 = (band.moved.row(k) - band.moved.row(i)).transpose(), N = f1.cross(f2);
        const double twice = N.norm();
        const Vector3 raised = (twice > 0 ? 1 / std::sqrt(twice) : 0.0) * N;
        first = edges.first[0] * f1 + edges.first[1] * f2 + edges.first[2] * raised - first;
        second = edges.second[0] * f1 + edges.second[1] * f2 + edges.second[2] * raised - second;
    };
    // The constraints have the displacements that lead from the fine shape to the aims.
    const PointsView aims = soft_.empty() ? band.moved : view(work->aims);
    system_.displace({still_, aims, band.fine, &from_aims_}, detailed,
                     [&](RowMatrix& b) { return gradients_.source(band.fine, change, work->forces, b); });
}

void DeformationTransfer::report(BindReport& report) const { system_.report(report); }

} // namespace sinew
