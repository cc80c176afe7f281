// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/graph/handle_graph.h"

#include <vector>

namespace sinew {

/// Clusters of a graph by farthest-point growth: each new seed is the node farthest from all seeds, and takes
/// over what is nearer to it than to any other. They never cross a handle's border; idle nodes are in none.
struct Clusters
{
    std::vector<int> label; ///< cluster of each node, -1 where idle
    std::vector<int> seeds; ///< node from which each cluster grew
    double radius = 0.0;    ///< no node is farther from its seed along the edges

    /// \param rest    (nodes, 3) where the nodes are.
    /// \param wanted  clusters; each part of each region is one at least.
    Clusters(const HandleGraph& graph, const Points& rest, int wanted);
};

/// The way between a graph and its clusters.
class ClusterMap
{
public:
    /// \param rest  (nodes, 3)
    ClusterMap(const HandleGraph& graph, const Points& rest, const Clusters& clusters);

    int cluster_count() const { return static_cast<int>(members_.size()); }
    /// Cluster of each node, -1 where idle.
    const std::vector<int>& label() const { return label_; }
    /// Number of nodes in each cluster.
    const std::vector<int>& members() const { return members_; }

    /// Clusters near a node with their shares, which sum to 1.
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

    /// (clusters, 3) means of the nodes' points over each cluster.
    void restrict(const PointsView& points, Points& means) const;
    Points restrict(const PointsView& points) const
    {
        Points means;
        restrict(points, means);
        return means;
    }
    /// (clusters) means of one number per node.
    std::vector<double> restrict(const std::vector<double>& values) const;

    /// Cluster old[p] is number p from now on.
    void renumber(const std::vector<int>& old);

private:
    std::vector<int> label_, members_;
    std::vector<int> offsets_{0}, clusters_;
    std::vector<double> weights_;
};

/// The graph of the clusters. One sits at the mean of its nodes; an edge collects the crossing w |e| over the
/// distance of the means; pulls of one handle add up.
/// \param rest  (nodes, 3)
HandleGraph graph_of_clusters(const HandleGraph& graph, const Points& rest, const ClusterMap& map);

} // namespace sinew
