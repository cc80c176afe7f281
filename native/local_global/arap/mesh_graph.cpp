// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/mesh_graph.h"

#include "native/operators/laplacian.h"

#include <algorithm>
#include <cmath>

namespace sinew {

namespace {

constexpr double least_weight = 1e-6; ///< as a share of the mean weight
constexpr double most_weight = 1e4;   ///< likewise

} // namespace

WeightBounds::WeightBounds(const SparseMatrix& L)
{
    double sum = 0.0;
    int count = 0;
    for (int c = 0; c < L.cols(); ++c)
        for (SparseMatrix::InnerIterator it(L, c); it; ++it)
            if (it.row() != c) {
                sum += std::abs(it.value());
                ++count;
            }
    const double mean = sum > 0 ? sum / count : 1.0;
    least = least_weight * mean;
    most = most_weight * mean;
}

double WeightBounds::bounded(double weight) const { return std::clamp(weight, least, most); }

GraphEdges cotan_edges(const SurfaceMesh& mesh)
{
    const SparseMatrix L = laplacian_matrix(mesh, Discretization::cotan);
    return edges_of(L, WeightBounds(L));
}

GraphEdges edges_of(const SparseMatrix& L, const WeightBounds& bounds)
{
    GraphEdges edges;
    for (int c = 0; c < L.cols(); ++c) {
        for (SparseMatrix::InnerIterator it(L, c); it; ++it)
            if (it.row() != c) {
                edges.neighbours.push_back(static_cast<int>(it.row()));
                edges.weights.push_back(bounds.bounded(-it.value()));
            }
        edges.offsets.push_back(static_cast<int>(edges.neighbours.size()));
    }
    return edges;
}

} // namespace sinew
