// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/pyramid/coarse_motion.h"

#include "native/core/parallel.h"
#include "native/mesh/components.h"
#include "native/methods/surface/linear/pyramid/second_differences.h"

#include <memory>
#include <utility>

namespace sinew {

int CoarseMotion::factorize(const SurfaceMesh& level, std::vector<Handle> handles, std::vector<int> group,
                            const std::function<void()>& completed)
{
    int degenerate = 0;
    SparseMatrix energy = second_difference_matrix(level, degenerate);
    Regions regions(std::move(handles), connected_components(level));
    system_.factorize(std::make_shared<SparseMatrix>(energy), regions, completed);
    constraints_ = regions.constraints();
    regions_ = std::move(regions);
    group_ = std::move(group);
    energy_.swap(energy);
    return degenerate;
}

SolveReport CoarseMotion::move(const Targets& targets, const MapBlend& blend, int groups,
                               Points& positions) const
{
    const PointsView base = targets.base();
    std::vector<Vector3> shifts(groups, Vector3::Zero());
    std::vector<int> counts(groups, 0);
    for (const auto& [vertex, handle] : constraints_) {
        const int g = group_[vertex];
        shifts[g] += targets.position(vertex, handle) - blend.mean(g) * base.row(vertex).transpose();
        ++counts[g];
    }
    for (int g = 0; g < groups; ++g)
        if (counts[g] > 0)
            shifts[g] /= counts[g];
    return system_.solve(targets, positions, [&](RowMatrix& b) {
        RowMatrix carried = RowMatrix::Zero(base.rows(), 3); // T y - y
        for (Eigen::Index v = 0; v < base.rows(); ++v)
            if (const int g = group_[v]; g >= 0) {
                const Vector3 y = base.row(v).transpose();
                carried.row(v) = (blend.mean(g) * y - y + shifts[g]).transpose();
            }
        const int n = static_cast<int>(base.rows());
        parallel_for(n, [&](int v) {
            Eigen::RowVector3d sum = Eigen::RowVector3d::Zero(); // rows of `energy_` sum to zero
            for (SparseMatrix::InnerIterator it(energy_, v); it; ++it)
                sum += it.value() * (carried.row(it.row()) - carried.row(v));
            b.row(v) = sum;
        });
        return parallel_sum(n, [&](int v) { return b.row(v).dot(carried.row(v)); });
    });
}

} // namespace sinew
