// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/laplacian.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/operators/tufted_cover.h"
#include "native/solvers/sparse_columns.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>

namespace sinew {

namespace {

constexpr double least_mass = 1e-6;            ///< of a vertex, as a share of the mean
constexpr double least_mass_degenerate = 1e-2; ///< the same for a vertex of a degenerate triangle

/// What one element adds between two vertices.
struct WeightedEdge
{
    int from, to;
    double weight;
};

/// The matrix of the quadratic form sum over the edges of w (f_i - f_j)^2. The columns are computed in
/// parallel, each as a sum over its edges in their order.
SparseMatrix matrix_of_edges(int n, const std::vector<WeightedEdge>& edges)
{
    std::vector<int> begin(n + 1, 0);
    for (const WeightedEdge& e : edges)
        if (e.from != e.to) {
            ++begin[e.from + 1];
            ++begin[e.to + 1];
        }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<int> incident(begin[n]);
    {
        std::vector<int> next(begin.begin(), begin.end() - 1);
        for (int k = 0; k < static_cast<int>(edges.size()); ++k)
            if (edges[k].from != edges[k].to) {
                incident[next[edges[k].from]++] = k;
                incident[next[edges[k].to]++] = k;
            }
    }
    return sparse_by_columns(n, n, [&](int v, SparseColumn& column) {
        if (begin[v] == begin[v + 1])
            return;
        double diagonal = 0;
        for (int at = begin[v]; at < begin[v + 1]; ++at) {
            const WeightedEdge& e = edges[incident[at]];
            diagonal += e.weight;
            column.add(e.from == v ? e.to : e.from, -e.weight);
        }
        column.add(v, diagonal);
    });
}

/// Mixed Voronoi area [MDSB03]: Voronoi in acute triangles; in an obtuse one, half the
/// triangle at the obtuse corner and a quarter at the others.
void add_mixed_areas(const SurfaceMesh& mesh, const Triangle& t, double area, VectorX& mass)
{
    std::array<Vector3, 3> edge; // edge[k] is opposite corner k
    for (int k = 0; k < 3; ++k)
        edge[k] = mesh.point(t[(k + 2) % 3]) - mesh.point(t[(k + 1) % 3]);
    std::array<double, 3> dot; // |u| |v| cos of the angle at corner k
    for (int k = 0; k < 3; ++k)
        dot[k] = -edge[(k + 1) % 3].dot(edge[(k + 2) % 3]);

    const int widest = static_cast<int>(std::ranges::min_element(dot) - dot.begin());
    for (int k = 0; k < 3; ++k) {
        if (dot[widest] < 0 || area == 0) {
            mass[t[k]] += area * (k == widest ? 0.5 : 0.25);
        } else {
            const int a = (k + 1) % 3;
            const int b = (k + 2) % 3;
            // 1/8 (|e_a|^2 cot_a + |e_b|^2 cot_b), with cot = dot / (2 area)
            mass[t[k]] += (edge[a].squaredNorm() * dot[a] + edge[b].squaredNorm() * dot[b]) / (16 * area);
        }
    }
}

std::optional<IntrinsicTriangles> cover_of(const SurfaceMesh& mesh, Discretization discretization)
{
    return discretization == Discretization::robust ? delaunay_cover(mesh) : std::nullopt;
}

/// Half of a triangle of the cover, of which the surface has two.
struct HalfTriangle
{
    std::array<double, 3> half_cotan; ///< at each corner
    double area;

    HalfTriangle(const std::array<double, 3>& lengths)
    {
        const auto [a, b, c] = lengths;
        const double longest = std::max({a, b, c});
        const double whole =
            0.25 * std::sqrt(std::max((a + b + c) * (b + c - a) * (a + c - b) * (a + b - c), 0.0));
        const double divisor = 16 * std::max(whole, needle * longest * longest);
        for (int k = 0; k < 3; ++k) {
            const double from = lengths[k], to = lengths[(k + 2) % 3], opposite = lengths[(k + 1) % 3];
            half_cotan[k] = divisor > 0 ? (from * from + to * to - opposite * opposite) / divisor : 0.0;
        }
        area = 0.5 * whole;
    }

    /// The mixed Voronoi area at a corner, without the lengths: area (1 + cot cot) / 4 of the other two.
    double share(int k) const
    {
        const int widest = static_cast<int>(std::ranges::min_element(half_cotan) - half_cotan.begin());
        if (half_cotan[widest] < 0)
            return area * (k == widest ? 0.5 : 0.25);
        return area * (0.25 + 4 * half_cotan[(k + 1) % 3] * half_cotan[(k + 2) % 3]);
    }
};

} // namespace

double least_area_for_order(int order) { return order < 2 ? needle : order < 3 ? 1e-3 : 1e-2; }

TriangleMetric triangle_metric(const SurfaceMesh& mesh, double least_area)
{
    const auto& triangles = mesh.triangles();
    const int count = static_cast<int>(triangles.size());
    TriangleMetric metric;
    metric.half_cotan.resize(count);
    metric.area.resize(count);
    std::vector<char> degenerate(count);
    parallel_for(count, [&](int t) {
        const auto [i, j, k] = triangles[t];
        const std::array<Vector3, 3> edge{mesh.point(k) - mesh.point(j), mesh.point(i) - mesh.point(k),
                                          mesh.point(j) - mesh.point(i)};
        const double longest =
            std::max({edge[0].squaredNorm(), edge[1].squaredNorm(), edge[2].squaredNorm()});
        const double area = 0.5 * edge[1].cross(edge[2]).norm();
        degenerate[t] = !(area > least_area * longest);
        const double divisor = 4 * std::max(area, least_area * longest);
        metric.area[t] = area;
        for (int c = 0; c < 3; ++c) {
            const double dot = -edge[(c + 1) % 3].dot(edge[(c + 2) % 3]);
            metric.half_cotan[t][c] =
                (divisor > 0 ? dot / divisor : 0.0) + (degenerate[t] ? 0.5 / std::sqrt(3.0) : 0.0);
        }
    });
    for (int t = 0; t < count; ++t)
        if (degenerate[t])
            metric.degenerate.push_back(t);
    return metric;
}

int degenerate_face_count(const SurfaceMesh& mesh, const TriangleMetric& metric)
{
    int count = 0;
    int last = -1; // the triangles of a face follow one another, so this counts each face once
    for (int t : metric.degenerate) {
        count += mesh.triangle_faces()[t] != last;
        last = mesh.triangle_faces()[t];
    }
    return count;
}

int degenerate_face_count(const SurfaceMesh& mesh, double least_area)
{
    return degenerate_face_count(mesh, triangle_metric(mesh, least_area));
}

SparseMatrix laplacian_matrix(const SurfaceMesh& mesh, Discretization discretization,
                              const TriangleMetric& metric, const ElementScale& scale)
{
    std::vector<WeightedEdge> edges;
    const auto add = [&](const std::vector<Triangle>& triangles, const auto& half_cotan) {
        edges.resize(3 * triangles.size());
        parallel_for(static_cast<int>(triangles.size()), [&](int t) {
            const double factor = scale ? scale(triangles[t]) : 1.0;
            const std::array<double, 3> weights = half_cotan(t);
            for (int c = 0; c < 3; ++c)
                edges[3 * static_cast<std::size_t>(t) + c] = {triangles[t][(c + 1) % 3],
                                                              triangles[t][(c + 2) % 3], factor * weights[c]};
        });
    };
    if (discretization == Discretization::uniform) {
        for (const auto& edge : mesh.edges())
            edges.push_back({edge[0], edge[1], scale ? scale(edge) : 1.0});
    } else if (const auto cover = cover_of(mesh, discretization)) {
        add(cover->triangles, [&](int t) { return HalfTriangle(cover->lengths[t]).half_cotan; });
    } else {
        add(mesh.triangles(), [&](int t) { return metric.half_cotan[t]; });
    }
    return matrix_of_edges(mesh.vertex_count(), edges);
}

SparseMatrix laplacian_matrix(const SurfaceMesh& mesh, Discretization discretization,
                              const ElementScale& scale, double least_area)
{
    return laplacian_matrix(mesh, discretization, triangle_metric(mesh, least_area), scale);
}

bool make_weights_positive(SparseMatrix& L)
{
    constexpr double rounding = 1e-10, kept = 1e-6;
    const auto for_entries = [&](const auto& body) {
        for (int column = 0; column < L.outerSize(); ++column)
            for (SparseMatrix::InnerIterator it(L, column); it; ++it)
                if (it.row() != column)
                    body(it);
    };
    double total = 0.0,
           largest = 0.0; // without the diagonal, which may hold more than the sum of the weights
    int count = 0;
    for_entries([&](auto& it) {
        total += std::abs(it.value());
        largest = std::max(largest, it.value());
        ++count;
    });
    if (!(largest * count > rounding * total))
        return false;
    VectorX sums = VectorX::Zero(L.cols());
    for_entries([&](auto& it) {
        if (it.value() > 0)
            it.valueRef() *= -kept;
        sums[it.col()] -= it.value();
    });
    for (int column = 0; column < L.outerSize(); ++column)
        for (SparseMatrix::InnerIterator it(L, column); it; ++it)
            if (it.row() == column)
                it.valueRef() = sums[column];
    return true;
}

VectorX mass_vector(const SurfaceMesh& mesh, Discretization discretization, const TriangleMetric& metric)
{
    const int n = mesh.vertex_count();
    if (discretization == Discretization::cotan)
        return VectorX::Ones(n);
    VectorX mass = VectorX::Zero(n);
    if (discretization == Discretization::uniform) {
        for (const auto& [a, b] : mesh.edges()) {
            mass[a] += 1;
            mass[b] += 1;
        }
        return mass;
    }
    if (const auto cover = cover_of(mesh, discretization)) {
        for (std::size_t t = 0; t < cover->triangles.size(); ++t)
            for (int k = 0; k < 3; ++k)
                mass[cover->triangles[t][k]] += HalfTriangle(cover->lengths[t]).share(k);
        return mass;
    }
    for (std::size_t t = 0; t < metric.area.size(); ++t)
        add_mixed_areas(mesh, mesh.triangles()[t], metric.area[t], mass);
    return mass;
}

VectorX mass_vector(const SurfaceMesh& mesh, Discretization discretization)
{
    return mass_vector(mesh, discretization, triangle_metric(mesh));
}

VectorX divisible_mass(const SurfaceMesh& mesh, Discretization discretization, const TriangleMetric& metric)
{
    VectorX mass = mass_vector(mesh, discretization, metric);
    const double mean = mass.mean() > 0 ? mass.mean() : 1.0;
    mass = mass.cwiseMax(least_mass * mean);
    for (int t : metric.degenerate)
        for (int v : mesh.triangles()[t])
            mass[v] = std::max(mass[v], least_mass_degenerate * mean);
    return mass;
}

VectorX divisible_mass(const SurfaceMesh& mesh, Discretization discretization, double least_area)
{
    return divisible_mass(mesh, discretization, triangle_metric(mesh, least_area));
}

SparseMatrix laplacian_power(const SurfaceMesh& mesh, int order, Discretization discretization)
{
    if (order < 1)
        throw InvalidOption("order: " + std::to_string(order) + " is below 1");
    const TriangleMetric metric = triangle_metric(mesh, least_area_for_order(order));
    const SparseMatrix L = laplacian_matrix(mesh, discretization, metric);
    const VectorX D = divisible_mass(mesh, discretization, metric).cwiseInverse();
    SparseMatrix power = L;
    for (int k = 1; k < order; ++k)
        power = sparse_product(power, D, L);
    const auto largest = [](const SparseMatrix& m) {
        return m.nonZeros() > 0 ? m.coeffs().abs().maxCoeff<Eigen::PropagateNaN>() : 0.0;
    };
    if (const double most = largest(power); !std::isfinite(most) || (most == 0.0 && largest(L) > 0.0))
        throw InvalidMesh("points: the mesh is too large or too small for order " + std::to_string(order) +
                          "; use another unit of length");
    return power;
}

} // namespace sinew
