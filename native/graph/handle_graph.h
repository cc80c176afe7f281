// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/regions.h"

#include <functional>
#include <vector>

namespace sinew {

/// Directed edges of a graph: those of node i stand in [offsets[i], offsets[i + 1]), its neighbours rising.
struct GraphEdges
{
    std::vector<int> offsets{0}, neighbours;
    std::vector<double> weights; ///< > 0, one per directed edge

    int size() const { return static_cast<int>(offsets.size()) - 1; }
};

/// A soft pull of a handle on a node.
struct GraphPull
{
    int node;
    int handle;
    double stiffness; ///< in the units of the method's Laplacian
};

/// What handles do to the nodes of a graph.
struct GraphHandles
{
    std::vector<int> hard;  ///< handle that holds each node, or -1
    std::vector<char> idle; ///< whether each node is in a part without a handle
    std::vector<GraphPull> pulls;

    GraphHandles() = default;
    /// \param diagonal  a vertex's own entry of the method's Laplacian, the unit of soft pulls; where it is
    ///                  zero, 1 is.
    GraphHandles(const Regions& regions, const std::function<double(int)>& diagonal);
};

/// A weighted graph of which handles hold some nodes and pull at others: a mesh, or clusters of one.
class HandleGraph
{
public:
    HandleGraph(GraphEdges edges, GraphHandles handles);

    int size() const { return edges_.size(); }
    const GraphEdges& edges() const { return edges_; }
    /// The handle that holds a node, or -1.
    int hard(int node) const { return handles_.hard[node]; }
    /// Whether a node is in a part without a handle.
    bool is_idle(int node) const { return handles_.idle[node]; }
    const std::vector<GraphPull>& pulls() const { return handles_.pulls; }

    /// The nodes that are neither held nor idle, rising.
    const std::vector<int>& free_nodes() const { return free_nodes_; }
    int free_count() const { return static_cast<int>(free_nodes_.size()); }
    /// A node's index among the free ones, or -1.
    int place(int node) const { return place_[node]; }

    /// The same graph; its node i is this one's node old[i].
    HandleGraph renumbered(const std::vector<int>& old) const;

private:
    GraphEdges edges_;
    GraphHandles handles_;
    std::vector<int> free_nodes_, place_;
};

/// new[old[i]] = i
std::vector<int> new_numbers(const std::vector<int>& old);

} // namespace sinew
