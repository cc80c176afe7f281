// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/laplacian.h"

#include "native/core/errors.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace sinew {

namespace {

constexpr double least_mass = 1e-6;            ///< of a vertex, as a share of the mean
constexpr double least_mass_degenerate = 1e-2; ///< of a vertex of a degenerate triangle

using Triplets = std::vector<Eigen::Triplet<double>>;

void add_edge(Triplets& entries, int i, int j, double weight)
{
    if (i == j)
        return;
    entries.emplace_back(i, i, weight);
    entries.emplace_back(j, j, weight);
    entries.emplace_back(i, j, -weight);
    entries.emplace_back(j, i, -weight);
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

} // namespace

double least_area_for_order(int order) { return order < 2 ? needle : order < 3 ? 1e-3 : 1e-2; }

TriangleMetric triangle_metric(const SurfaceMesh& mesh, double least_area)
{
    const auto& triangles = mesh.triangles();
    TriangleMetric metric;
    metric.half_cotan.resize(triangles.size());
    metric.area.resize(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const auto [i, j, k] = triangles[t];
        const std::array<Vector3, 3> edge{mesh.point(k) - mesh.point(j), mesh.point(i) - mesh.point(k),
                                          mesh.point(j) - mesh.point(i)};
        const double longest =
            std::max({edge[0].squaredNorm(), edge[1].squaredNorm(), edge[2].squaredNorm()});
        const double area = 0.5 * edge[1].cross(edge[2]).norm();
        const bool degenerate = !(area > least_area * longest);
        const double divisor = 4 * std::max(area, least_area * longest);
        metric.area[t] = area;
        if (degenerate)
            metric.degenerate.push_back(static_cast<int>(t));
        for (int c = 0; c < 3; ++c) {
            const double dot = -edge[(c + 1) % 3].dot(edge[(c + 2) % 3]);
            metric.half_cotan[t][c] =
                (divisor > 0 ? dot / divisor : 0.0) + (degenerate ? 0.5 / std::sqrt(3.0) : 0.0);
        }
    }
    return metric;
}

int degenerate_face_count(const SurfaceMesh& mesh, double least_area)
{
    int count = 0;
    int last = -1; // triangles of one face follow each other
    for (int t : triangle_metric(mesh, least_area).degenerate) {
        count += mesh.triangle_faces()[t] != last;
        last = mesh.triangle_faces()[t];
    }
    return count;
}

SparseMatrix laplacian_matrix(const SurfaceMesh& mesh, Discretization discretization,
                              const ElementScale& scale, double least_area)
{
    const int n = mesh.vertex_count();
    Triplets entries;
    if (discretization == Discretization::uniform) {
        for (const auto& edge : mesh.edges())
            add_edge(entries, edge[0], edge[1], scale ? scale(edge) : 1.0);
    } else {
        const TriangleMetric metric = triangle_metric(mesh, least_area);
        const auto& triangles = mesh.triangles();
        entries.reserve(12 * triangles.size());
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            const double factor = scale ? scale(triangles[t]) : 1.0;
            for (int c = 0; c < 3; ++c)
                add_edge(entries, triangles[t][(c + 1) % 3], triangles[t][(c + 2) % 3],
                         factor * metric.half_cotan[t][c]);
        }
    }
    SparseMatrix L(n, n);
    L.setFromTriplets(entries.begin(), entries.end());
    return L;
}

VectorX mass_vector(const SurfaceMesh& mesh, Discretization discretization)
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
    const TriangleMetric metric = triangle_metric(mesh);
    for (std::size_t t = 0; t < metric.area.size(); ++t)
        add_mixed_areas(mesh, mesh.triangles()[t], metric.area[t], mass);
    return mass;
}

VectorX divisible_mass(const SurfaceMesh& mesh, Discretization discretization, double least_area)
{
    VectorX mass = mass_vector(mesh, discretization);
    const double mean = mass.mean() > 0 ? mass.mean() : 1.0;
    mass = mass.cwiseMax(least_mass * mean);
    for (int t : triangle_metric(mesh, least_area).degenerate)
        for (int v : mesh.triangles()[t])
            mass[v] = std::max(mass[v], least_mass_degenerate * mean);
    return mass;
}

SparseMatrix laplacian_power(const SurfaceMesh& mesh, int order, Discretization discretization)
{
    if (order < 1)
        throw InvalidOption("order: " + std::to_string(order) + " is below 1");
    const double least_area = least_area_for_order(order);
    const SparseMatrix L = laplacian_matrix(mesh, discretization, {}, least_area);
    const VectorX D = divisible_mass(mesh, discretization, least_area).cwiseInverse();
    SparseMatrix power = L;
    for (int k = 1; k < order; ++k)
        power = SparseMatrix(power * D.asDiagonal()) * L;
    return power;
}

} // namespace sinew
