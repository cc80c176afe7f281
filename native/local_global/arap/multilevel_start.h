// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/local_global/arap/arap_problem.h"
#include "native/local_global/arap/cluster_motions.h"
#include "native/local_global/graph/clusters.h"
#include "native/mesh/regions.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <vector>

namespace sinew {

/// One coarser problem: the clusters of the finer one's nodes.
struct RotationLevel
{
    ClusterMap map; ///< from the finer nodes to those of this level
    ArapSystem graph;
    Points rest; ///< (nodes, 3)

    /// \param finer_rest  (finer nodes, 3)
    /// \throw FactorizationFailed, Cancelled
    RotationLevel(const HandleGraph& finer, const GraphCells& cells, const Points& finer_rest,
                  const Clusters& clusters, const Progress& progress = {});

    /// The level above a graph with an eighth of its nodes; none if there would be too few, or nearly as
    /// many, or if it cannot be factorised.
    static std::optional<RotationLevel> coarser(const HandleGraph& finer, const GraphCells& cells,
                                                const Points& finer_rest, const Progress& progress = {});
};

/// Where the handles want the held and the pulled nodes of a graph.
struct GraphGoals
{
    Points targets, pulls;
    GraphGoals() = default;
    GraphGoals(const ArapSystem& graph, const Targets& targets) { set(graph, targets); }
    void set(const ArapSystem& graph, const Targets& targets);
};

/// The workspace of a solve on one graph.
struct GraphWorkspace
{
    ArapBuffers buffers;
    LbfgsWorkspace descent;
    GraphGoals goals;
    Points x, base;
    std::vector<Eigen::Quaterniond> rotations;
};

/// A hierarchy of coarser graphs. From the poses of the handles alone it computes a start for ARAP that is so
/// close to the minimum that some iterations on the mesh are enough.
///
/// Each level has an eighth of the nodes of the finer one, and at least 60; its nodes are clusters of the
/// finer nodes, see graph_of_clusters(). On the coarsest level, the rotations of the handles are blended by
/// harmonic weights. Then each level minimises its energy and hands its rotations down to the finer one. The
/// motions of the clusters of a coarser level help each graph, that of the mesh included. All levels together
/// cost as much as 2 to 4 iterations on the mesh.
class MultilevelStart
{
public:
    MultilevelStart() = default;
    /// \param fine  the graph of the mesh, which is not kept.
    /// \param rest  (nodes, 3)
    /// \throw FactorizationFailed, Cancelled
    MultilevelStart(const ArapSystem& fine, const Points& rest, const Progress& progress);

    const std::vector<RotationLevel>& levels() const { return levels_; }
    /// The motions that help the graph of the mesh, for 0, or that of a level, counted from 1. They are empty
    /// on a mesh without levels and on a coarsest level with few nodes.
    const ClusterMotions& motions(int graph) const { return motions_[graph]; }
    std::int64_t factor_bytes() const;

private:
    void add_motions(const ArapSystem& fine, const Points& rest);

    std::vector<RotationLevel> levels_; ///< fine to coarse
    std::vector<ClusterMotions> motions_; ///< one more than levels
};

/// One solve on all graphs of a cascade.
class CascadeSolve
{
public:
    /// \param fine_problem  the problem on the graph that the cascade was made of.
    /// \param targets       of the nodes; like all of these, they have to outlive this object.
    /// \param work          one per level.
    CascadeSolve(const MultilevelStart& cascade, ArapProblem& fine_problem, const ArapSystem& fine,
                 const Targets& targets, std::vector<GraphWorkspace>& work);

    /// Sets the rotations of the fine problem, which then depend on the targets alone.
    void start();

    /// start(), and then as many iterations on the fine problem as a level of a cascade gets.
    /// \param work  of the fine problem.
    /// \return the rotation of each of its nodes.
    const std::vector<Eigen::Quaterniond>& solve(GraphWorkspace& work);

private:
    const std::vector<Eigen::Quaterniond>& descend(int level, ArapProblem& problem, GraphWorkspace& work,
                                                   double floor);

    const MultilevelStart& cascade_;
    ArapProblem& fine_problem_;
    const ArapSystem& fine_;
    const Targets& targets_;
    std::vector<GraphWorkspace>& work_;
    std::vector<ArapProblem> problems_;
    std::vector<double> floors_;
};

} // namespace sinew
