// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/memory.h"
#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/local_global/graph/clusters.h"
#include "native/local_global/graph/handle_graph.h"
#include "native/solvers/single_factor.h"
#include "native/solvers/systems/conjugate_gradients.h"

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <vector>

namespace sinew {

/// A matrix for the first nodes of a graph: (A x)_i = own_i x_i + weight sum_j w_ij (x_i - x_j), where later x_j are 0.
struct GraphMatrix
{
    int rows = 0;
    std::span<const double> entries; ///< w_ij >= 0, one per directed edge
    double weight = 1.0;
    std::vector<double> own; ///< (rows)
    const SingleFactor* coarse = nullptr; ///< of such a matrix for the first nodes of the coarser graph
};

/// Solves with matrices of a graph whose factors would take too much memory, by conjugate gradients with a cycle between
/// two grids: a polynomial smoother on the graph itself, and the factor of a coarser graph, which a cascade has anyway.
/// A cycle is symmetric and positive definite whatever the coarse graph is, as 2 bounds the eigenvalues of all matrices
/// with a dominant diagonal of 1. No matrix is kept: its entries are those of the graph. About 310 bytes per node, most
/// of them the workspace.
///
/// Smoother: J. Lottes. "Optimal polynomial smoothers for multigrid V-cycles." Numer. Linear Algebra Appl. 30(6), 2023.
class GraphIteration
{
public:
    /// \param map  to the coarser graph. All that is given has to stay where it is.
    GraphIteration(const GraphEdges& edges, const ClusterMap& map, std::vector<GraphMatrix> matrices);

    /// What this and the cascade take of a graph, about, before anything of it is there.
    static std::int64_t bytes_for(int nodes) { return std::int64_t{360} * nodes; }

    /// X = A^-1 B; B may be X. Ticks in each product with A.
    /// \param matrix  the number of A.
    /// \param error   what the last cycle begins with, as a share of the largest entry of X.
    /// \throw NotConverged, Cancelled
    void solve(int matrix, const Points& b, Points& x, double error, const Progress& progress) const;

    std::int64_t bytes() const; ///< with one workspace, without the coarse graph

private:
    using Four = Eigen::Array4f;
    struct Work
    {
        std::vector<Four> r, step, next, sum; ///< (nodes)
        Points coarse; ///< (clusters, 3)
        Columns load, solution;
        const Progress* progress = nullptr;
    };
    struct Link
    {
        int node;
        float share;
    };
    struct Matrix : GraphMatrix
    {
        std::vector<float> inverse_diagonal;
    };

    template <class Column, class Body>
    void multiply(const Matrix& matrix, const Work& work, const std::vector<Column>& x, Body&& body) const;
    void smooth(const Matrix& matrix, Work& work) const;
    void cycle(const Matrix& matrix, Work& work, const Columns& from, Columns& to) const;

    const GraphEdges& edges_;
    const ClusterMap& map_;
    std::vector<int> first_link_; ///< of each cluster
    std::vector<Link> links_; ///< the nodes that follow the cluster
    std::vector<Matrix> matrices_;
    mutable Pool<Work> work_;
};

} // namespace sinew
