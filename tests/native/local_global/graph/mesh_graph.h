// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/local_global/graph/clusters.h"
#include "native/local_global/graph/handle_graph.h"
#include "native/mesh/components.h"
#include "native/operators/laplacian.h"
#include "tests/native/shapes.h"

namespace sinew::graphs {

/// The edges of a mesh with cotan weights, all of them positive.
inline GraphEdges edges_of(const SurfaceMesh& mesh)
{
    const SparseMatrix L = laplacian_matrix(mesh, Discretization::cotan);
    GraphEdges edges;
    for (int c = 0; c < mesh.vertex_count(); ++c) {
        for (SparseMatrix::InnerIterator it(L, c); it; ++it)
            if (it.row() != c) {
                edges.neighbours.push_back(static_cast<int>(it.row()));
                edges.weights.push_back(std::max(1e-6, -it.value()));
            }
        edges.offsets.push_back(static_cast<int>(edges.neighbours.size()));
    }
    return edges;
}

/// A bar held at one end and held or pulled at the other, beside a sphere that nothing holds.
struct BarAndSphere
{
    SurfaceMesh mesh = shapes::joined(shapes::bar(24, 6), shapes::sphere(2), {0, 30, 0});
    std::vector<Handle> handles = shapes::ends(shapes::bar(24, 6), 2);
    Regions regions;
    HandleGraph graph;

    explicit BarAndSphere(double weight = 1.0) : regions(made(weight)), graph(edges_of(mesh), held()) {}

private:
    Regions made(double weight)
    {
        handles[1].weights.assign(handles[1].vertices.size(), weight);
        return Regions(handles, connected_components(mesh));
    }
    GraphHandles held() const
    {
        return GraphHandles(regions, [](int) { return 1.0; });
    }
};

} // namespace sinew::graphs
