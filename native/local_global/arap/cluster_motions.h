// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/local_global/arap/arap_system.h"
#include "native/local_global/graph/handle_graph.h"
#include "native/solvers/single_factor.h"

#include <memory>
#include <vector>

namespace sinew {

/// Motions of a graph whose unknowns are a translation y_J and a turn w_J of each of some hundred clusters of
/// its nodes. A step in the metric of the Laplacian hardly changes what costs little energy: how a long limb
/// bends or a thin neck turns. Such changes are smooth, and these motions express them. With weights P that
/// sum to 1 over the clusters near a node, node i at x_i moves by
///
///     sum_J P_iJ (y_J + w_J x (x_i - (X_J + sum_K P_iK X_K) / 2)),    and its cell turns by sum_J P_iJ w_J,
///
/// where X_J is the mean of the nodes of cluster J. With the half of the offsets this is exact not only for
/// rigid motions, but also for bends, which are quadratic in x: with whole offsets, bends would cost energy
/// as if the clusters were joined by hinges that rust. Clusters that are held neither move nor turn.
///
/// The metric K of these motions is the Hessian at rest of the energy of points and rotations, restricted to
/// them, and a step uses it in the present frames of the clusters. That of a coarser graph serves, too.
class ClusterMotions
{
public:
    ClusterMotions() = default;
    /// \param rest      (nodes, 3)
    /// \param label     (nodes) the cluster of each node, -1 for idle ones.
    /// \param clusters  the graph of the clusters, the free ones first.
    /// \param metric    that of the same clusters on a coarser graph of the same shape, or null for its own.
    /// \throw FactorizationFailed
    ClusterMotions(const ArapSystem& graph, const Points& rest, std::vector<int> label,
                   const HandleGraph& clusters, std::shared_ptr<const SingleFactor> metric = nullptr);

    bool empty() const { return unknowns_ == 0; }
    const std::shared_ptr<const SingleFactor>& metric() const { return metric_; }

    /// One motion; kept from one step to the next, it is not allocated again.
    struct Motion
    {
        Points places;               ///< (clusters, 3) X
        std::vector<Matrix3> frames; ///< one per free cluster
        Points offsets, forces;      ///< (free nodes, 3)
        MatrixX pushes, solution;    ///< the system's right side and its solution, six numbers per cluster
        std::vector<Eigen::Matrix<double, 3, 4>> maps; ///< of the offsets of a cluster's nodes to their moves
        Points turns; ///< (free clusters, 3)
    };

    /// Solves for the motion that lowers the energy, no cluster of which turns by more than 1.
    /// \param x          (free nodes, 3)
    /// \param points     three numbers per node
    /// \param rotations  nine numbers per node
    /// \param gradient   (free nodes, 3) for fixed rotations.
    /// \param torque     (nodes, 3) minus the change of the energy as the cells turn; or empty for zero.
    /// \return how fast the energy falls at first, per share of the motion
    double solve(const Points& x, const double* points, const double* rotations, const Points& gradient,
                 const Points& torque, double torque_share, Motion& motion) const;
    /// Prepares a share of the solution for nodes().
    void scale(double share, Motion& motion) const;
    /// Where the motion takes node i from x_i, and how its cell turns.
    void move(const Motion& motion, int i, const Eigen::RowVector3d& x, Eigen::RowVector3d& to,
              Eigen::RowVector3d& turn) const;

private:
    struct Share
    {
        int cluster;
        double weight;
    };
    void weigh(const Points& rest, const Points& places, const HandleGraph& clusters);
    SparseMatrix hessian(const ArapSystem& graph, const Points& rest, const Points& places) const;

    int free_ = 0, unknowns_ = 0; ///< free clusters; with six unknowns each
    std::vector<int> label_;
    std::vector<int> first_member_, members_; ///< the nodes of each cluster
    std::vector<int> first_share_; ///< of each free node
    std::vector<Share> shares_;
    std::vector<int> first_node_; ///< of each free cluster, whom it moves
    std::vector<Share> moved_; ///< the nodes and their weights
    std::shared_ptr<const SingleFactor> metric_;
};

} // namespace sinew
