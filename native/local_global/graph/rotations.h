// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/local_global/graph/clusters.h"
#include "native/local_global/graph/handle_graph.h"
#include "native/solvers/single_factor.h"

#include <Eigen/Geometry>

#include <vector>

namespace sinew {

/// One rotation per node. A held node has the rotation closest to its handle's pose. Between the handles the
/// quaternions of these rotations are blended by harmonic weights, all of them on the same side of 4-space.
/// Idle nodes have the identity.
/// \param laplacian  minus the entries of a Laplacian, one per directed edge of the graph.
/// \param factor     of that Laplacian on the free nodes, with the pulls on its diagonal.
/// \param poses      (k) the poses of the handles.
std::vector<Eigen::Quaterniond> blended_rotations(const HandleGraph& graph,
                                                  const std::vector<double>& laplacian,
                                                  const SingleFactor& factor, const Poses& poses);

/// The rotation that a node gets from the clusters near it: the mean of their quaternions by the node's
/// shares, all on the side of its own cluster's. The node is not idle.
/// \param rotations  one per cluster.
Eigen::Quaterniond handed_down(const ClusterMap& map, const std::vector<Eigen::Quaterniond>& rotations,
                               int node);

} // namespace sinew
