// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/semi_regular/control_motion.h"

#include "native/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace sinew {

namespace {

/// How much stiffer handles pull at points of the smooth surface than the plate does there. It brings a
/// single vertex to a ten-thousandth of its way.
constexpr double stiffest = 1e4;

} // namespace

void smooth_points(const SparseRows& S, const PointsView& y, Points& points)
{
    points.resize(S.rows(), 3);
    parallel_for(static_cast<int>(S.rows()), [&](int i) {
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        for (SparseRows::InnerIterator it(S, i); it; ++it)
            sum += it.value() * y.row(it.col());
        points.row(i) = sum;
    });
}

void ControlMotion::factorize(const SurfaceMesh& control, SparseRows&& S, const Regions& regions,
                              const std::vector<int>& levels, std::vector<int> group)
{
    const SparseMatrix A = plate_energy(control);
    const VectorX diagonal = A.diagonal();
    const double mean = diagonal.mean() > 0 ? diagonal.mean() : 1.0;
    constraints_ = regions.constraints();
    const std::size_t count = constraints_.size(), hard = count - regions.soft().size();
    std::vector<bool> free(control.vertex_count());
    for (int j = 0; j < control.vertex_count(); ++j)
        free[j] = group[j] >= 0;
    held_.assign(count, -1);
    pulling_.clear();
    group_of_.clear();
    std::vector<double> stiffness;
    for (std::size_t i = 0; i < count; ++i) {
        const SparseRows::InnerIterator first(S, static_cast<Eigen::Index>(i));
        group_of_.push_back(group[first.col()]);
        if (i < hard && levels[i] == 0) {
            held_[i] = static_cast<int>(first.col());
            free[held_[i]] = false;
            continue;
        }
        double unit = 0.0;
        for (SparseRows::InnerIterator it(S, static_cast<Eigen::Index>(i)); it; ++it)
            unit += it.value() * (diagonal[it.col()] > 0 ? diagonal[it.col()] : mean);
        // A diagonal entry is one over the area of a vertex, so those of the surface are larger.
        const double pull =
            i < hard ? stiffest : regions.soft()[i - hard].stiffness() * std::ldexp(1.0, 2 * levels[i]);
        stiffness.push_back(unit * (levels[i] == 0 ? pull : std::min(pull, stiffest)));
        pulling_.push_back(static_cast<int>(i));
    }
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t k = 0; k < pulling_.size(); ++k)
        for (SparseRows::InnerIterator it(S, pulling_[k]); it; ++it)
            entries.emplace_back(static_cast<int>(k), static_cast<int>(it.col()), it.value());
    SparseRows pulls(static_cast<Eigen::Index>(pulling_.size()), control.vertex_count());
    pulls.setFromTriplets(entries.begin(), entries.end());
    system_.factorize(A, pulls, std::move(stiffness), free);
    smooth_points(S, view(control.points()), rest_);
    S_.swap(S);
    group_ = std::move(group);
}

SolveReport ControlMotion::move(const Targets& targets, const MapBlend& blend, int groups, Points& positions,
                                Workspace& work) const
{
    const PointsView base = targets.base();
    if (targets.incoming)
        smooth_points(S_, base, work.base);
    const Targets smooth{targets.poses, view(rest_),
                         targets.incoming ? std::optional(view(work.base)) : std::nullopt, targets.from_rest};
    const PointsView points = smooth.base();
    const int count = static_cast<int>(constraints_.size());
    const auto at = [&](int i) { return smooth.position(i, constraints_[i].handle); };
    std::vector<Vector3> shifts(groups, Vector3::Zero());
    std::vector<int> counts(groups, 0);
    for (int i = 0; i < count; ++i) {
        const int g = group_of_[i];
        shifts[g] += at(i) - blend.mean(g) * points.row(i).transpose();
        ++counts[g];
    }
    for (int g = 0; g < groups; ++g)
        if (counts[g] > 0)
            shifts[g] /= counts[g];
    const auto carried = [&](int g, const Vector3& y) -> Vector3 { return blend.mean(g) * y + shifts[g]; };
    work.u.setZero(base.rows(), 3);
    work.pulled.resize(static_cast<Eigen::Index>(pulling_.size()), 3);
    const auto left = [&](int i) -> Eigen::RowVector3d {
        return (at(i) - carried(group_of_[i], points.row(i).transpose())).transpose();
    };
    for (int i = 0; i < count; ++i)
        if (held_[i] >= 0)
            work.u.row(held_[i]) = left(i);
    parallel_for(static_cast<int>(pulling_.size()), [&](int k) { work.pulled.row(k) = left(pulling_[k]); });
    const SolveReport report = system_.solve(work.u, work.pulled, work.system);
    positions.resize(base.rows(), 3);
    parallel_for(static_cast<int>(base.rows()), [&](int j) {
        const Vector3 y = base.row(j).transpose();
        if (group_[j] >= 0)
            positions.row(j) = carried(group_[j], y).transpose() + work.u.row(j);
        else
            positions.row(j) = y.transpose();
    });
    return report;
}

} // namespace sinew
