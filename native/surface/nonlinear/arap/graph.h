// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/graph/handle_graph.h"
#include "native/solvers/single_factor.h"
#include "native/surface/nonlinear/arap/kernels.h"

#include <cstdint>
#include <vector>

namespace sinew {

/// What the cells of an as-rigid-as-possible energy are made of, besides the edges of their graph.
struct ArapCells
{
    std::vector<double> rigidity;        ///< of each node's cell, > 0
    double smoothing = 0.0;              ///< alpha A: weight of |R_i - R_j|^2
    bool rims = false;                   ///< cells are made of triangles, not of edges
    std::vector<ArapTriangle> triangles; ///< with rims

    double edge_rigidity(int i, int j) const { return 0.5 * (rigidity[i] + rigidity[j]); }
    /// L, one entry per directed edge: weights times the rigidity of the cells they lie in.
    std::vector<double> laplacian(const GraphEdges& edges) const;
};

/// The nodes of a graph in chunks, and their edges and triangles as ArapKernels take them. The cells of the
/// first chunks, the moving ones, depend on free nodes; of those in the others, which are none with
/// smoothing, rotations stay.
struct ArapChunks
{
    std::vector<ArapChunk> all;
    int moving = 0;               ///< number of the moving ones
    std::vector<int> edges, ends; ///< see ArapView
    std::vector<double> weights;
    std::vector<ArapTriangle> triangles;

    /// Nodes [0, moving_nodes) are in moving chunks, [moving_nodes, nodes) in others, later ones in none.
    ArapChunks(const GraphEdges& graph, const std::vector<ArapTriangle>& triangles, int moving_nodes,
               int nodes);

    /// Nodes in all chunks.
    int present() const { return all.empty() ? 0 : all.back().end; }
};

/// An as-rigid-as-possible problem on a weighted graph, factorised: the mesh itself, or one level of the
/// cascade. Its nodes are the graph's in another order: first the free ones, then held ones that have a free
/// neighbour, then the others, last the idle ones; among these so that neighbours lie close in memory, along
/// a curve that fills space.
class ArapGraph
{
public:
    /// \param rest  (nodes, 3)
    /// \throw FactorizationFailed
    ArapGraph(const HandleGraph& graph, ArapCells cells, const Points& rest);

    const HandleGraph& nodes() const { return nodes_; }
    const ArapCells& cells() const { return cells_; }
    const ArapChunks& chunks() const { return chunks_; }
    /// The number of each node in the graph that this one was made of.
    const std::vector<int>& order() const { return order_; }

    int size() const { return nodes_.size(); }
    int free_count() const { return nodes_.free_count(); }
    bool is_smooth() const { return cells_.smoothing > 0; }

    /// L, one entry per directed edge.
    const std::vector<double>& laplacian() const { return laplacian_; }
    /// Of L on the free nodes, pulls on the diagonal.
    const SingleFactor& position_factor() const { return position_factor_; }
    /// Of the rotation field; empty without smoothing.
    const SingleFactor& rotation_factor() const { return rotation_factor_; }
    std::int64_t factor_bytes() const { return position_factor_.bytes() + rotation_factor_.bytes(); }

    /// E of arap.h is this many times the function whose Hessian L bounds.
    double energy_factor() const { return cells_.rims ? 6.0 : 4.0; }
    /// sum r_i w_ij |p_i - p_j|^2: rounding in F is relative to it.
    /// \param base  (nodes, 3)
    double scale(const PointsView& base) const;
    /// scale() of the rest.
    double rest_scale() const { return rest_scale_; }

private:
    struct Parts;
    ArapGraph(Parts&& parts);

    HandleGraph nodes_;
    ArapCells cells_;
    std::vector<double> laplacian_;
    SingleFactor position_factor_, rotation_factor_;
    double rest_scale_;
    std::vector<int> order_;
    ArapChunks chunks_;
};

} // namespace sinew
