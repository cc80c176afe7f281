// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/local_global/arap/arap_problem.h"
#include "native/local_global/graph/clusters.h"
#include "native/solvers/optimization/metric_lbfgs.h"

#include <Eigen/Geometry>

#include <vector>

namespace sinew {

/// The iterations from one correction to the next, the correction included. More seldom, soft changes lag;
/// more often, the steps between cannot smooth what a correction leaves.
constexpr int correction_period = 3;

/// The problem of one graph with corrections by that of a coarser one, whose nodes are clusters of its nodes.
///
/// A step in the metric of the Laplacian hardly changes what costs little energy: how a long limb bends or a
/// thin neck turns. The coarser graph finds such changes at little cost, but its energy has another minimum.
/// Therefore a correction minimises the coarser energy less a linear term. The term is such that the coarser
/// gradient, at the means of the present points, equals the sums of the finer gradient over the clusters: at
/// the finer minimum the coarser problem changes nothing. How far the rotations of the clusters turn is then
/// handed down to the nodes, and a linear solve gives the points that fit them.
///
/// A. Brandt. "Multi-Level Adaptive Solutions to Boundary-Value Problems." Mathematics of Computation 31,
/// 1977: the full approximation scheme.
class CorrectedProblem final : public MetricProblem
{
public:
    explicit CorrectedProblem(ArapProblem& problem) : problem_(problem) {}

    /// From now on, `coarser` corrects this problem.
    /// \param map   from the nodes of this problem to those of the coarser one.
    /// \param work  the workspace of the coarser descent.
    void correct_by(CorrectedProblem& coarser, const ClusterMap& map, LbfgsWorkspace& work)
    {
        coarser_ = &coarser;
        map_ = &map;
        work_ = &work;
    }

    double evaluate(const Points& x, Points& gradient) override;
    void precondition(const Points& gradient, Points& z) const override
    {
        problem_.precondition(gradient, z);
    }
    void keep_state() override { problem_.keep_state(); }
    void restore_state() override { problem_.restore_state(); }
    bool correct(const Points& x, const Points& gradient, Points& better) override;

private:
    ArapProblem& problem_;
    CorrectedProblem* coarser_ = nullptr;
    const ClusterMap* map_ = nullptr;
    LbfgsWorkspace* work_ = nullptr;
    Points tilt_, origin_; ///< the energy is less by tilt . (x - origin), unless `tilt_` is empty
    Points x_, sums_;
    std::vector<Matrix3> before_;
    std::vector<Eigen::Quaterniond> turns_;
};

} // namespace sinew
