// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/components.h"
#include "native/operators/laplacian.h"
#include "native/surface/nonlinear/arap/energy.h"
#include "tests/native/shapes.h"

namespace sinew::graphs {

/// The graph of a mesh without obtuse angles, factorised; painted with random rigidity on request.
/// \param[in,out] mesh  its vertices are numbered as the graph's nodes then.
inline ArapGraph of(SurfaceMesh& mesh, const std::vector<Handle>& handles, double smoothness,
                    bool rims = false, bool painted = false)
{
    ArapGraph graph;
    graph.size = mesh.vertex_count();
    const TriangleMetric metric = triangle_metric(mesh);
    for (double area : metric.area)
        graph.smoothing += smoothness * area;
    const SparseMatrix L = laplacian_matrix(mesh, Discretization::cotan);
    graph.offsets = {0};
    for (int c = 0; c < graph.size; ++c) {
        for (SparseMatrix::InnerIterator it(L, c); it; ++it)
            if (it.row() != c) {
                graph.neighbours.push_back(static_cast<int>(it.row()));
                graph.weights.push_back(std::max(1e-6, -it.value()));
            }
        graph.offsets.push_back(static_cast<int>(graph.neighbours.size()));
    }
    if (rims) {
        graph.rims = true;
        for (std::size_t t = 0; t < metric.area.size(); ++t) {
            const Triangle& v = mesh.triangles()[t];
            const auto& c = metric.half_cotan[t];
            graph.triangles.push_back({{v[0], v[1], v[2]}, {c[0], c[1], c[2]}});
        }
    }
    shapes::Random random(1);
    graph.rigidity.assign(graph.size, 1.0);
    if (painted)
        for (double& r : graph.rigidity)
            r = 0.2 + random.unit();
    const Regions regions(handles, connected_components(mesh));
    for (int i = 0; i < graph.size; ++i) {
        graph.hard.push_back(regions.hard(i));
        graph.idle.push_back(regions.is_idle(i));
    }
    for (const SoftConstraint& s : regions.soft())
        graph.pulls.push_back({s.vertex, s.handle, s.stiffness()});
    graph.set_metric();
    graph.factorize(mesh.points());
    const std::vector<int> old = graph.renumber(mesh.points());
    std::vector<int> renamed(graph.size), corners;
    Points points(graph.size, 3);
    for (int i = 0; i < graph.size; ++i) {
        renamed[old[i]] = i;
        points.row(i) = mesh.points().row(old[i]);
    }
    for (const Triangle& t : mesh.triangles())
        for (int vertex : t)
            corners.push_back(renamed[vertex]);
    mesh = SurfaceMesh(points, std::vector<int>(corners.size() / 3, 3), corners);
    return graph;
}

} // namespace sinew::graphs
