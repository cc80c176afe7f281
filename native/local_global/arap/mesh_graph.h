// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/local_global/graph/handle_graph.h"
#include "native/mesh/surface_mesh.h"

namespace sinew {

/// The bounds between which the weights of an energy have to lie.
struct WeightBounds
{
    double least; ///< so that no term is negative and the graph stays connected
    double most; ///< so that the factor stays well conditioned

    WeightBounds(double least, double most) : least(least), most(most) {}
    /// From the mean size of the weights in a Laplacian.
    explicit WeightBounds(const SparseMatrix& L);
    double bounded(double weight) const;
};

/// The edges of a mesh with the cotan weights of operators/laplacian.h, within their bounds.
GraphEdges cotan_edges(const SurfaceMesh& mesh);

/// Minus the entries of a matrix L beside its diagonal, within `bounds`.
GraphEdges edges_of(const SparseMatrix& L, const WeightBounds& bounds);

} // namespace sinew
