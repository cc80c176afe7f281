// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/pyramids/morph.h"

#include "native/core/parallel.h"
#include "native/operators/fits/rotation_fit.h"

#include <utility>

namespace sinew {

namespace {

Vector3 mean(std::span<const int> vertices, const PointsView& points)
{
    Vector3 sum = Vector3::Zero();
    for (const int v : vertices)
        sum += points.row(v).transpose();
    return sum / static_cast<double>(vertices.size());
}

} // namespace

RigidFit::RigidFit(std::span<const int> vertices, const PointsView& before, const PointsView& after)
    : from(mean(vertices, before)), to(mean(vertices, after))
{
    Matrix3 covariance = Matrix3::Zero();
    for (const int v : vertices)
        covariance += (after.row(v).transpose() - to) * (before.row(v).transpose() - from).transpose();
    R = fit_rotation(covariance);
}

RegionMorph::RegionMorph(std::span<const int> vertices, const PointsView& from, const PointsView& to,
                         double t)
    : fit_(vertices, from, to), t_(t), middle_((1 - t) * fit_.from + t * fit_.to),
      turn_(t < 1 ? Eigen::Quaterniond::Identity().slerp(t, Eigen::Quaterniond(fit_.R)).toRotationMatrix()
                  : fit_.R)
{
}

PyramidMorph::PyramidMorph(const Rings& rings, const std::vector<double>& shares, Points target)
    : target_(std::move(target)), weights_(rings.mean_value_weights(view(target_))),
      differences_(weights_.shares)
{
    for (std::size_t a = 0; a < shares.size(); ++a)
        differences_[a] -= shares[a];
}

void PyramidMorph::mix(const PyramidCells& cells, const Rings& rings, const PointsView& rest,
                       const PointsView& base, double t, PyramidShape& shape,
                       std::vector<Eigen::Quaterniond>& turns) const
{
    cells.keep(base, shape);
    turns.resize(cells.cell_count());
    const PointsView target = view(target_);
    parallel_for(
        cells.cell_count(),
        [&](int c) {
            const int i = cells.order()[c], first = rings.offsets()[i];
            const Eigen::Quaterniond turn = rings.turn(base, target, i);
            const Matrix3 back = turn.toRotationMatrix().transpose();
            Vector3 tip = Vector3::Zero(), other = Vector3::Zero();
            for (int a = first; a < rings.offsets()[i + 1]; ++a) {
                Eigen::Map<Vector3> edge(shape.edges.data() +
                                         3 * static_cast<std::size_t>(cells.offsets()[c] + a - first));
                const Vector3 own = edge,
                              its = back * (target.row(rings.neighbours()[a]) - target.row(i)).transpose();
                edge = (1 - t) * own + t * its;
                other -= weights_.shares[a] * its;
                tip += t * differences_[a] * edge;
            }
            Eigen::Map<Vector3> own(shape.tips.data() + 3 * static_cast<std::size_t>(c));
            own = (1 - t) * own + t * other + tip;
            const bool moved = base.data() != rest.data();
            turns[c] =
                Eigen::Quaterniond::Identity().slerp(t, moved ? rings.turn(rest, base, i) * turn : turn);
        },
        512);
}

} // namespace sinew
