// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/local_global/graph/handle_graph.h"

#include <span>
#include <vector>

namespace sinew {

/// Clusters of a graph by farthest-point growth: each new seed is the node farthest from all seeds, and takes
/// over the nodes that are nearer to it than to any other seed. No cluster crosses the border of a handle;
/// idle nodes are in no cluster.
///
/// Edges are measured in shares of the size of the graph that are rounded up to one of eight numbers per
/// octave, so that sums of them are exact and equal distances stay equal, and equally far nodes are taken by
/// their places (order_by_place()). Thus neither the unit of length, nor the order of the nodes, nor the last
/// bits of the rest shape choose the clusters, except where a length lies just beside a bound.
struct Clusters
{
    std::vector<int> label; ///< the cluster of each node, -1 for idle nodes
    std::vector<int> seeds; ///< the node from which each cluster grew
    double unit = 1.0;           ///< the size of the graph, by the moments of its edges
    std::vector<double> lengths; ///< (edges) the rounded lengths
    double radius = 0.0; ///< the largest distance of a node from its seed along the edges, in rounded lengths

    /// \param rest     (nodes, 3) where the nodes are.
    /// \param wanted   number of clusters; there may be more, as each part of each region has one at least.
    /// \throw Cancelled
    Clusters(const HandleGraph& graph, const Points& rest, int wanted, const Progress& progress = {});
};

/// Takes values from the nodes of a graph to its clusters and back.
class ClusterMap
{
public:
    /// \throw Cancelled
    ClusterMap(const HandleGraph& graph, const Clusters& clusters, const Progress& progress = {});

    int cluster_count() const { return static_cast<int>(members_.size()) - 1; }
    /// The cluster of each node, -1 for idle nodes.
    const std::vector<int>& label() const { return label_; }
    /// The nodes of a cluster, in rising order.
    std::span<const int> nodes(int cluster) const
    {
        return {nodes_.data() + members_[cluster], nodes_.data() + members_[cluster + 1]};
    }

    /// The clusters near a node, with weights that sum to 1.
    struct Shares
    {
        const int* clusters;
        const double* weights;
        int count;
    };
    Shares shares(int node) const
    {
        const int first = offsets_[node];
        return {clusters_.data() + first, weights_.data() + first, offsets_[node + 1] - first};
    }

    /// (clusters, 3) the mean of the points of each cluster's nodes.
    void restrict(const PointsView& points, Points& means) const;
    Points restrict(const PointsView& points) const
    {
        Points means;
        restrict(points, means);
        return means;
    }
    /// (clusters) the same for one number per node.
    std::vector<double> restrict(const std::vector<double>& values) const;

    /// From now on, cluster old[p] has the number p.
    void renumber(const std::vector<int>& old);

private:
    void collect_nodes(int clusters);

    std::vector<int> label_;
    std::vector<int> members_, nodes_; ///< the nodes of cluster p begin at nodes_[members_[p]]
    std::vector<int> offsets_{0}, clusters_;
    std::vector<double> weights_;
};

/// The graph whose nodes are the clusters. A cluster lies at the mean of its nodes. The weight of the edge
/// between two clusters is the sum of w |e| over the edges from one to the other, divided by the distance of
/// their means. The pulls of one handle on a cluster add up.
/// \param rest  (nodes, 3)
HandleGraph graph_of_clusters(const HandleGraph& graph, const Points& rest, const ClusterMap& map);

} // namespace sinew
