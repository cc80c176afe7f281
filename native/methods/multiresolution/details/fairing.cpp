// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/details/fairing.h"

#include "native/core/parallel.h"
#include "native/mesh/half_edges.h"
#include "native/operators/laplacian.h"
#include "native/solvers/sparse_columns.h"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace sinew {

Regions faired_regions(const SurfaceMesh& mesh, const Regions& regions, const Components& parts)
{
    const int n = mesh.vertex_count();
    std::vector<bool> border(n, false), held(n, false);
    const std::vector<HalfEdge> sides = sorted_half_edges(mesh);
    for_each_edge(sides, [&](std::span<const HalfEdge> edge) {
        if (edge.size() == 1)
            border[edge[0].low] = border[edge[0].high] = true;
    });
    for (const HalfEdge& side : sides)
        if (border[side.low] || border[side.high])
            held[side.low] = held[side.high] = true;
    Handle rim;
    for (int v = 0; v < n; ++v)
        if (held[v] && regions.is_free(v))
            rim.vertices.push_back(v);
    std::vector<Handle> handles = regions.handles();
    if (!rim.vertices.empty())
        handles.push_back(std::move(rim));
    return {std::move(handles), parts};
}

double mean_edge(const SurfaceMesh& mesh)
{
    double sum = 0.0;
    int count = 0;
    for_each_edge(sorted_half_edges(mesh), [&](std::span<const HalfEdge> edge) {
        sum += (mesh.point(edge[0].low) - mesh.point(edge[0].high)).norm();
        ++count;
    });
    return count == 0 ? 0.0 : sum / count;
}

Fairing::Fairing(const SurfaceMesh& rest, const Regions& regions, double wavelength, const Regions* wider)
    : still_(regions.handle_count(), Pose::Identity())
{
    const TriangleMetric metric = triangle_metric(rest, least_area_for_order(2));
    const SparseMatrix L = laplacian_matrix(rest, Discretization::cotan_voronoi, metric);
    const VectorX mass = divisible_mass(rest, Discretization::cotan_voronoi, metric);
    const double weight = std::pow(wavelength / (2 * std::numbers::pi), 4);
    auto H = std::make_shared<SparseMatrix>(sparse_product(L, VectorX(weight * mass.cwiseInverse()), L));
    for (int v = 0; v < rest.vertex_count(); ++v)
        H->coeffRef(v, v) += mass[v];
    H->makeCompressed();
    system_.factorize(std::move(H), regions, {}, wider);
}

void Fairing::smooth(const PointsView& y, Points& smoothed) const
{
    // The rows of L sum to zero, so M y - H y has no need of diagonals, and those alone hold M and the pulls.
    const SparseMatrix& H = system_.matrix();
    system_.displace({still_, y, {}, nullptr}, smoothed, [&](RowMatrix& b) {
        parallel_for(static_cast<int>(y.rows()), [&](int v) {
            Vector3 sum = Vector3::Zero();
            for (SparseMatrix::InnerIterator entry(H, v); entry; ++entry)
                sum += entry.value() * (y.row(v) - y.row(entry.row())).transpose();
            b.row(v) = sum.transpose();
        });
        return 0.0;
    });
}

} // namespace sinew
