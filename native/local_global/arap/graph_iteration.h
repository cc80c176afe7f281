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
#include <memory>
#include <vector>

namespace sinew {

class ArapSystem;

/// Solves with the matrices of an ArapSystem whose factors would take too much memory, by conjugate gradients with a
/// cycle between two grids: a polynomial smoother on the graph itself, and the factor of the first level of the cascade,
/// which has an eighth of its nodes and is there for the start anyway. A cycle is symmetric and positive definite
/// whatever the coarse graph is, as 2 bounds the eigenvalues of all matrices with a dominant diagonal of 1. No matrix
/// is kept: its entries are those of the graph. About 310 bytes per node, and what the cascade takes.
///
/// Smoother: J. Lottes. "Optimal polynomial smoothers for multigrid V-cycles." Numer. Linear Algebra Appl. 30(6), 2023.
class GraphIteration
{
public:
    /// \param fine, map, coarse  see ArapSystem::iterate(); all must stay where they are.
    /// \param rest               (nodes, 3)
    GraphIteration(const ArapSystem& fine, const Points& rest, const ClusterMap& map,
                   const ArapSystem& coarse);
    ~GraphIteration();

    /// What this and the cascade take of a graph, about, before anything of it is there.
    static std::int64_t bytes_for(int nodes) { return std::int64_t{360} * nodes; }

    /// See ArapSystem. B may be X. They tick in each product with the matrix.
    void solve_positions(const Points& b, Points& x, double error, const Progress& progress) const;
    void solve_rotations(const Points& b, Points& x, double error, const Progress& progress) const;

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
    /// The first rows of the matrix. Row i is own_i x_i + weight sum_j w_ij (x_i - x_j), with 0 for later x_j.
    struct Matrix
    {
        int rows = 0, coarse_rows = 0;
        const std::vector<double>* entries = nullptr; ///< w_ij, one per directed edge
        double weight = 1.0;
        std::vector<double> own;
        std::vector<float> inverse_diagonal;
        const SingleFactor* coarse = nullptr;
    };

    void complete(Matrix& matrix) const;
    template <class Column, class Body>
    void multiply(const Matrix& matrix, const Work& work, const std::vector<Column>& x, Body&& body) const;
    void smooth(const Matrix& matrix, Work& work) const;
    void cycle(const Matrix& matrix, Work& work, const Columns& from, Columns& to) const;
    void solve(const Matrix& matrix, const Points& b, Points& x, double error,
               const Progress& progress) const;

    const GraphEdges& edges_;
    const ClusterMap& map_;
    std::vector<int> first_link_; ///< of each cluster
    std::vector<Link> links_; ///< the nodes that follow the cluster
    std::vector<double> rotation_entries_; ///< only with rims
    Matrix positions_, rotations_;
    mutable Pool<Work> work_;
};

} // namespace sinew
