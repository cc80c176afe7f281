// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/graph/clusters.h"
#include "native/graph/handle_graph.h"
#include "native/solvers/single_factor.h"

#include <Eigen/Geometry>

#include <vector>

namespace sinew {

/// One rotation per node: those of the handles, blended between them by harmonic weights, quaternions on one
/// side. The identity where idle.
/// \param laplacian  minus the entries of a Laplacian, one per directed edge of the graph.
/// \param factor     of that Laplacian on the free nodes, with the pulls on its diagonal.
/// \param poses      (k) of the handles, whose rotations are those closest to them.
std::vector<Eigen::Quaterniond> blended_rotations(const HandleGraph& graph,
                                                  const std::vector<double>& laplacian,
                                                  const SingleFactor& factor, const Poses& poses);

/// The rotation of a node that is not idle, of those of the clusters near it: their mean, quaternions on one
/// side.
/// \param rotations  one per cluster.
Eigen::Quaterniond handed_down(const ClusterMap& map, const std::vector<Eigen::Quaterniond>& rotations,
                               int node);

} // namespace sinew
