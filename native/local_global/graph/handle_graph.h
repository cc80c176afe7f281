// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/regions.h"

#include <functional>
#include <vector>

namespace sinew {

/// The directed edges of a graph: those of node i are [offsets[i], offsets[i + 1]), by rising neighbour.
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

/// Which nodes of a graph the handles hold or pull.
struct GraphHandles
{
    std::vector<int> hard;  ///< the handle that holds each node, or -1
    std::vector<char> idle; ///< whether each node is in a part without a handle
    std::vector<GraphPull> pulls;

    GraphHandles() = default;
    /// \param diagonal  gives a vertex's own entry of the method's Laplacian. This is the unit of soft pulls;
    ///                  where it is not positive, the unit is 1.
    GraphHandles(const Regions& regions, const std::function<double(int)>& diagonal);
};

/// A weighted graph, some of whose nodes are held or pulled by handles. The nodes are the vertices of a mesh,
/// or clusters of them.
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
    /// The index of a node in free_nodes(), or -1.
    int place(int node) const { return place_[node]; }

    /// The same graph with other numbers: its node i is node old[i] of this one.
    HandleGraph renumbered(const std::vector<int>& old) const;

private:
    GraphEdges edges_;
    GraphHandles handles_;
    std::vector<int> free_nodes_, place_;
};

/// The inverse of a renumbering: result[old[i]] = i.
std::vector<int> new_numbers(const std::vector<int>& old);

} // namespace sinew
