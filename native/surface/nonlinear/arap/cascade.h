// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/graph/clusters.h"
#include "native/mesh/regions.h"
#include "native/surface/nonlinear/arap/energy.h"

#include <Eigen/Geometry>

#include <vector>

namespace sinew {

/// One coarser problem: the clusters of the finer one's nodes.
struct ArapLevel
{
    ClusterMap map; ///< of the finer nodes to this level's
    ArapGraph graph;
    Points rest; ///< (nodes, 3)

    /// \param finer_rest  (finer nodes, 3)
    /// \throw FactorizationFailed
    ArapLevel(const ArapGraph& finer, const Points& finer_rest, const Clusters& clusters);
};

/// Where held nodes go and pulled nodes would go, for one graph.
struct ArapGoals
{
    Points targets, pulls;
    ArapGoals() = default;
    ArapGoals(const ArapGraph& graph, const Targets& targets) { set(graph, targets); }
    void set(const ArapGraph& graph, const Targets& targets);
};

/// What a solve on one graph works in; see ArapBuffers.
struct ArapWorkspace
{
    ArapBuffers buffers;
    LbfgsWorkspace descent;
    ArapGoals goals;
    Points x, base;
    std::vector<Eigen::Quaterniond> rotations;
};

/// A hierarchy of clustered graphs that turns the handle poses alone into a start for ARAP,
/// close enough that a handful of fine iterations finish it.
///
/// Levels hold a quarter of the nodes each, none fewer than 60; clusters grow by farthest
/// points and never cross a handle's border. A node sits at its cluster's mean; an edge
/// collects the crossing w |e| over the distance of the means. From the coarsest level, whose
/// rotations blend the handles' by harmonic weights, each level is minimised and hands its
/// rotations down. The whole costs as much as 3 to 9 fine iterations.
class ArapCascade
{
public:
    ArapCascade() = default;
    /// \param fine  the mesh's own graph; read here and not kept.
    /// \param rest  (nodes, 3)
    /// \throw FactorizationFailed, Cancelled
    ArapCascade(const ArapGraph& fine, const Points& rest, const Progress& progress);

    /// Rotations for the fine problem, from poses, base and targets alone.
    void start(ArapProblem& fine_problem, const ArapGraph& fine, const Targets& targets,
               std::vector<ArapWorkspace>& work) const;
    void start(ArapProblem& fine_problem, const ArapGraph& fine, const Targets& targets) const
    {
        std::vector<ArapWorkspace> work;
        start(fine_problem, fine, targets, work);
    }

    const std::vector<ArapLevel>& levels() const { return levels_; }

private:
    std::vector<ArapLevel> levels_; ///< fine to coarse
};

} // namespace sinew
