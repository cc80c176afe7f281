// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/local_global/arap/arap_kernels.h"
#include "native/local_global/graph/clusters.h"
#include "native/local_global/graph/handle_graph.h"
#include "native/solvers/single_factor.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace sinew {

/// What defines the cells of an as-rigid-as-possible energy, besides the edges of the graph.
struct GraphCells
{
    std::vector<double> rigidity;        ///< of the cell of each node, > 0
    double smoothing = 0.0;              ///< alpha A, the weight of |R_i - R_j|^2
    bool rims = false;                   ///< whether cells consist of triangles instead of edges
    std::vector<GraphTriangle> triangles; ///< empty without rims

    double edge_rigidity(int i, int j) const { return 0.5 * (rigidity[i] + rigidity[j]); }
    /// Minus the entries of L, one per directed edge: the weights times the rigidity of the cells that have
    /// the edge.
    std::vector<double> laplacian(const GraphEdges& edges) const;
    /// What each cell has on the diagonal of the system of all rotations, 2/3 sum w |e|^2, raised so that it is
    /// positive.
    /// \param rest  (nodes, 3)
    std::vector<double> moments(const GraphEdges& edges, const Points& rest) const;
};

/// The nodes of a graph in chunks, with their edges and triangles in the layout of ArapKernels. The first
/// chunks are the moving ones, whose cells depend on free nodes. The cells of the others keep their
/// rotations; with smoothing, there are no others.
struct GraphChunks
{
    std::vector<GraphChunk> all;
    int moving = 0;               ///< number of moving chunks
    std::vector<int> edges, ends; ///< see GraphView
    std::vector<double> weights;
    std::vector<GraphTriangle> triangles;

    /// Nodes [0, moving_nodes) are in moving chunks, [moving_nodes, nodes) in other chunks, later nodes in
    /// none.
    GraphChunks(const GraphEdges& graph, const std::vector<GraphTriangle>& triangles, int moving_nodes,
                int nodes);

    /// Number of nodes in all chunks.
    int present() const { return all.empty() ? 0 : all.back().end; }
};

class GraphIteration;

/// A weighted graph with the factors of its as-rigid-as-possible energy: that of the mesh, or of one level of
/// the cascade. The nodes have other numbers than in the graph that it is made of: first come the free ones,
/// then held ones with a free neighbour, then the other held ones, and last the idle ones. Within each of
/// these groups they follow a space-filling curve, so that neighbours lie close in memory.
class ArapSystem
{
public:
    /// \param rest  (nodes, 3)
    /// \param factorized  whether it has factors; else iterate() has to be called before a solve.
    /// \throw FactorizationFailed
    ArapSystem(const HandleGraph& graph, GraphCells cells, const Points& rest, bool factorized = true);
    ~ArapSystem();
    ArapSystem(ArapSystem&&) noexcept;
    ArapSystem& operator=(ArapSystem&&) noexcept;

    /// From now on, iterations take the place of the factors, see GraphIteration.
    /// \param rest    (nodes, 3) in the order of the nodes.
    /// \param coarse  the graph of the clusters of `map`, with factors; both must stay where they are.
    void iterate(const Points& rest, const ClusterMap& map, const ArapSystem& coarse);
    bool iterates() const { return iteration_ != nullptr; }

    const HandleGraph& nodes() const { return nodes_; }
    const GraphCells& cells() const { return cells_; }
    const GraphChunks& chunks() const { return chunks_; }
    /// The number that each node has in the graph that this one was made of.
    const std::vector<int>& order() const { return order_; }

    int size() const { return nodes_.size(); }
    int free_count() const { return nodes_.free_count(); }
    bool is_smooth() const { return cells_.smoothing > 0; }

    /// Minus the entries of L, one per directed edge.
    const std::vector<double>& laplacian() const { return laplacian_; }
    /// The factor of L on the free nodes, with the pulls on its diagonal.
    const SingleFactor& position_factor() const { return position_factor_; }
    /// The factor of the system that moves all rotations together; empty without smoothing.
    const SingleFactor& rotation_factor() const { return rotation_factor_; }
    std::int64_t factor_bytes() const; ///< or those of the iteration

    /// X = L^-1 B on the free nodes.
    /// \param error  what iterations may leave, as a share of the largest entry of X.
    /// \throw NotConverged, Cancelled  only where iterations solve.
    void solve_positions(const Points& b, Points& x, double error, const Progress& progress) const;
    /// The same for the system of all rotations.
    void solve_rotations(const Points& b, Points& x, double error, const Progress& progress) const;

    /// E of methods/surface/nonlinear/arap.h, divided by this, is a function whose Hessian L bounds.
    double energy_factor() const { return cells_.rims ? 6.0 : 4.0; }
    /// sum r_i w_ij |p_i - p_j|^2. The rounding error of the energy is proportional to it.
    /// \param base  (nodes, 3)
    double scale(const PointsView& base) const;
    /// scale() of the rest.
    double rest_scale() const { return rest_scale_; }

private:
    struct Parts;
    ArapSystem(Parts&& parts);

    HandleGraph nodes_;
    GraphCells cells_;
    std::vector<double> laplacian_;
    SingleFactor position_factor_, rotation_factor_;
    double rest_scale_;
    std::vector<int> order_;
    GraphChunks chunks_;
    std::vector<double>
        turning_; ///< (edges) r_ij w_ij, only after iterate() with rims; else those are laplacian()
    std::unique_ptr<const GraphIteration> iteration_; ///< after iterate()
};

} // namespace sinew
