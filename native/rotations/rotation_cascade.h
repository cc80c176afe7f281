// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/graph/clusters.h"
#include "native/mesh/regions.h"
#include "native/rotations/graph_problem.h"

#include <Eigen/Geometry>

#include <vector>

namespace sinew {

/// One coarser problem: the clusters of the finer one's nodes.
struct RotationLevel
{
    ClusterMap map; ///< from the finer nodes to those of this level
    RotationGraph graph;
    Points rest; ///< (nodes, 3)

    /// \param finer_rest  (finer nodes, 3)
    /// \throw FactorizationFailed
    RotationLevel(const RotationGraph& finer, const Points& finer_rest, const Clusters& clusters);
};

/// Where the handles want the held and the pulled nodes of a graph.
struct GraphGoals
{
    Points targets, pulls;
    GraphGoals() = default;
    GraphGoals(const RotationGraph& graph, const Targets& targets) { set(graph, targets); }
    void set(const RotationGraph& graph, const Targets& targets);
};

/// The workspace of a solve on one graph.
struct GraphWorkspace
{
    GraphBuffers buffers;
    LbfgsWorkspace descent;
    GraphGoals goals;
    Points x, base;
    std::vector<Eigen::Quaterniond> rotations;
};

/// A hierarchy of coarser graphs. From the poses of the handles alone it computes a start for ARAP that is so
/// close to the minimum that some iterations on the mesh are enough.
///
/// Each level has a quarter of the nodes of the finer one, and at least 60; its nodes are clusters of the
/// finer nodes, see graph_of_clusters(). On the coarsest level, the rotations of the handles are blended by
/// harmonic weights. Then each level minimises its energy and hands its rotations down to the finer one. All
/// levels together cost as much as 3 to 9 iterations on the mesh.
class RotationCascade
{
public:
    RotationCascade() = default;
    /// \param fine  the graph of the mesh, which is not kept.
    /// \param rest  (nodes, 3)
    /// \throw FactorizationFailed, Cancelled
    RotationCascade(const RotationGraph& fine, const Points& rest, const Progress& progress);

    /// Sets the rotations of the fine problem, which then depend on the targets alone.
    void start(GraphProblem& fine_problem, const RotationGraph& fine, const Targets& targets,
               std::vector<GraphWorkspace>& work) const;
    void start(GraphProblem& fine_problem, const RotationGraph& fine, const Targets& targets) const
    {
        std::vector<GraphWorkspace> work;
        start(fine_problem, fine, targets, work);
    }

    const std::vector<RotationLevel>& levels() const { return levels_; }

private:
    std::vector<RotationLevel> levels_; ///< fine to coarse
};

} // namespace sinew
