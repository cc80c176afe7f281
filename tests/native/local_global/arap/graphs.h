// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/local_global/arap/arap_system.h"
#include "native/mesh/components.h"
#include "native/operators/laplacian.h"
#include "tests/native/local_global/graph/mesh_graph.h"
#include "tests/native/shapes.h"

namespace sinew::graphs {

/// Handles at the lower and the upper end of a unit sphere.
inline std::vector<Handle> poles(const SurfaceMesh& mesh)
{
    return {{shapes::where(mesh, [](const Vector3& p) { return p.z() < -0.8; }), {}},
            {shapes::where(mesh, [](const Vector3& p) { return p.z() > 0.8; }), {}}};
}

/// The graph of a mesh without obtuse angles, painted with random rigidity on request.
/// \param[in,out] mesh  its vertices are numbered as the graph's nodes then.
inline ArapSystem of(SurfaceMesh& mesh, const std::vector<Handle>& handles, double smoothness,
                     bool rims = false, bool painted = false)
{
    const TriangleMetric metric = triangle_metric(mesh);
    GraphCells cells;
    for (double area : metric.area)
        cells.smoothing += smoothness * area;
    if (rims) {
        cells.rims = true;
        for (std::size_t t = 0; t < metric.area.size(); ++t) {
            const Triangle& v = mesh.triangles()[t];
            const auto& c = metric.half_cotan[t];
            cells.triangles.push_back({{v[0], v[1], v[2]}, {c[0], c[1], c[2]}});
        }
    }
    shapes::Random random(1);
    cells.rigidity.assign(mesh.vertex_count(), 1.0);
    if (painted)
        for (double& r : cells.rigidity)
            r = 0.2 + random.unit();
    const Regions regions(handles, connected_components(mesh));
    const GraphHandles held(regions, [](int) { return 1.0; });
    ArapSystem graph(HandleGraph(edges_of(mesh), held), cells, mesh.points());
    const std::vector<int> renamed = new_numbers(graph.order());
    std::vector<int> corners;
    Points points(graph.size(), 3);
    for (int i = 0; i < graph.size(); ++i)
        points.row(i) = mesh.points().row(graph.order()[i]);
    for (const Triangle& t : mesh.triangles())
        for (int vertex : t)
            corners.push_back(renamed[vertex]);
    mesh = SurfaceMesh(points, std::vector<int>(corners.size() / 3, 3), corners);
    return graph;
}

} // namespace sinew::graphs
