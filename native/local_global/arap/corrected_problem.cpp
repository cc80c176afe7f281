// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/corrected_problem.h"

#include "native/core/parallel.h"
#include "native/operators/fits/rotation_fit.h"

#include <limits>

namespace sinew {

namespace {

constexpr int grain = 256; ///< clusters per parallel chunk
/// Evaluations of the coarser problem at its start. They fit its rotations, so that its gradient there
/// depends on the points alone.
constexpr int fits = 3;
constexpr int iterations = 4, most_iterations = 30; ///< the latter where no coarser graph corrects
constexpr double tolerance = 1e-7; ///< small, as the energies differ little from one graph to the next

} // namespace

double CorrectedProblem::evaluate(const Points& x, Points& gradient)
{
    const double energy = problem_.evaluate(x, gradient);
    if (tilt_.size() == 0)
        return energy;
    gradient -= tilt_;
    return energy - (tilt_.array() * (x - origin_).array()).sum();
}

bool CorrectedProblem::correct(const Points& x, const Points& gradient, Points& better)
{
    if (!coarser_)
        return false;
    const ClusterMap& map = *map_;
    ArapProblem& coarse = coarser_->problem_;
    problem_.refresh(x);

    const int clusters = map.cluster_count(), free = coarse.free_count();
    Points& origin = coarser_->origin_;
    origin.resize(free, 3);
    sums_.resize(free, 3);
    before_.resize(clusters);
    turns_.resize(clusters);
    parallel_for(
        clusters,
        [&](int p) {
            Matrix3 rotations = Matrix3::Zero();
            Eigen::RowVector3d points = Eigen::RowVector3d::Zero(), gradients = points;
            for (int i : map.nodes(p)) {
                rotations += problem_.rotation(i);
                if (p < free) { // then all its nodes are free
                    points += x.row(i);
                    gradients += gradient.row(i);
                }
            }
            coarse.set_rotation(p, fit_rotation(rotations));
            if (p < free) {
                origin.row(p) = points / static_cast<double>(map.nodes(p).size());
                sums_.row(p) = gradients;
            }
        },
        grain);

    Points& tilt = coarser_->tilt_;
    for (int k = 0; k < fits; ++k)
        coarse.evaluate(origin, tilt);
    tilt -= sums_;
    parallel_for(clusters, [&](int p) { before_[p] = coarse.rotation(p); }, grain);

    x_ = origin;
    minimize(*coarser_, x_,
             {.max_iterations = coarser_->coarser_ ? iterations : most_iterations,
              .tolerance = tolerance,
              .floor = -std::numeric_limits<double>::infinity(),
              .correction_period = correction_period},
             {}, work_);
    coarse.refresh(x_);
    tilt.resize(0, 3);

    parallel_for(
        clusters, [&](int p) { turns_[p] = Eigen::Quaterniond(coarse.rotation(p) * before_[p].transpose()); },
        grain);
    problem_.turn(map, turns_);
    better = x;
    problem_.relax(better, tilt_);
    return true;
}

} // namespace sinew
