// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/components.h"
#include "native/operators/laplacian.h"
#include "native/surface/nonlinear/arap_energy.h"
#include "tests/native/shapes.h"

namespace sinew::graphs {

/// The graph of a mesh without obtuse angles, factorised; painted with random rigidity on request.
inline ArapGraph of(const SurfaceMesh& mesh, const std::vector<Handle>& handles, double smoothness,
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
        std::vector<std::vector<ArapWing>> around(graph.size);
        for (std::size_t t = 0; t < metric.area.size(); ++t) {
            const Triangle& v = mesh.triangles()[t];
            const auto& c = metric.half_cotan[t];
            for (int k = 0; k < 3; ++k) {
                const int b = (k + 1) % 3, d = (k + 2) % 3;
                around[v[k]].push_back({v[b], v[d], c[d], c[b], c[k]});
            }
        }
        graph.wing_offsets = {0};
        for (const auto& wings : around) {
            graph.wings.insert(graph.wings.end(), wings.begin(), wings.end());
            graph.wing_offsets.push_back(static_cast<int>(graph.wings.size()));
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
    return graph;
}

} // namespace sinew::graphs
