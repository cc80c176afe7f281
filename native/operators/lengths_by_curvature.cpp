// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/lengths_by_curvature.h"

#include "native/core/errors.h"
#include "native/mesh/remeshing/manifold.h"
#include "native/operators/curvature.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

namespace sinew {

namespace {

constexpr double steepest = 0.5; ///< rise of the length along an edge

/// The largest principal curvature at each vertex, by amount, on any side of the lines.
std::vector<double> bends_of_faces(const Manifold& surface)
{
    const std::vector<Triangle> parted = surface.parted_at_lines();
    std::vector<int> vertices, corners;
    for (std::size_t t = 0; t < parted.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            corners.push_back(parted[t][k]);
            if (parted[t][k] == static_cast<int>(vertices.size())) // they are numbered as they come
                vertices.push_back(surface.triangles[t][k]);
        }
    Points points(vertices.size(), 3);
    for (Eigen::Index v = 0; v < points.rows(); ++v)
        points.row(v) = surface.points[vertices[v]].transpose();
    const Curvature found =
        curvature(SurfaceMesh(std::move(points), std::vector<int>(parted.size(), 3), std::move(corners)));
    std::vector<double> bends(surface.points.size(), 0.0);
    for (std::size_t v = 0; v < vertices.size(); ++v)
        for (const VectorX& principal : found.principal)
            bends[vertices[v]] = std::max(bends[vertices[v]], std::abs(principal[v]));
    return bends;
}

/// How much borders and folds bend at each vertex: one over the radius of the circle through three points.
std::vector<double> bends_of_lines(const Manifold& surface)
{
    std::vector<std::vector<int>> beside(surface.points.size());
    for (const Manifold::Line& line : surface.lines)
        for (int end : {0, 1})
            beside[line.edge[end]].push_back(line.edge[1 - end]);
    std::vector<double> bends(surface.points.size(), 0.0);
    for (std::size_t v = 0; v < bends.size(); ++v)
        if (beside[v].size() == 2 && !surface.stays[v]) {
            const Vector3 a = surface.points[beside[v][0]] - surface.points[v];
            const Vector3 b = surface.points[beside[v][1]] - surface.points[v];
            const double sides = a.norm() * b.norm() * (a - b).norm();
            bends[v] = sides > 0.0 ? 2.0 * a.cross(b).norm() / sides : 0.0;
        }
    return bends;
}

/// Lowers lengths until they rise by at most so much along each edge.
void grade(VectorX& lengths, const std::vector<Vector3>& points, const std::vector<Triangle>& triangles,
           const std::vector<int>& originals)
{
    std::vector<std::vector<int>> beside(points.size());
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) {
            beside[t[k]].push_back(t[(k + 1) % 3]);
            beside[t[k]].push_back(t[(k + 2) % 3]);
        }
    using Waiting = std::pair<double, int>;
    std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> waiting;
    for (int v = 0; v < static_cast<int>(points.size()); ++v)
        waiting.emplace(lengths[originals[v]], v);
    while (!waiting.empty()) {
        const auto [length, v] = waiting.top();
        waiting.pop();
        if (length > lengths[originals[v]])
            continue;
        for (int other : beside[v]) {
            const double most = length + steepest * (points[v] - points[other]).norm();
            if (most < lengths[originals[other]]) {
                lengths[originals[other]] = most;
                waiting.emplace(most, other);
            }
        }
    }
}

} // namespace

VectorX lengths_by_curvature(const SurfaceMesh& mesh, const CurvatureLengthOptions& options)
{
    require_at_least(options.tolerance, 0.0, "tolerance");
    require_at_least(options.shortest, 0.0, "shortest");
    require_at_least(options.longest, 0.0, "longest");
    const double size = (mesh.points().colwise().maxCoeff() - mesh.points().colwise().minCoeff()).norm();
    const double tolerance = options.tolerance > 0.0 ? options.tolerance : 1e-3 * size;
    const double longest = options.longest > 0.0 ? options.longest : 0.1 * size;
    const double shortest = options.shortest > 0.0 ? options.shortest : std::min(2.0 * tolerance, longest);
    if (shortest > longest)
        throw InvalidOption("shortest must not be more than longest");
    Manifold surface(mesh, {});
    surface.keep_lines(options.angle, 0.0);
    const std::vector<double> of_faces = bends_of_faces(surface), of_lines = bends_of_lines(surface);
    VectorX lengths = VectorX::Constant(mesh.vertex_count(), longest);
    for (std::size_t v = 0; v < of_faces.size(); ++v) {
        const double square =
            6.0 * tolerance / std::max(of_faces[v], of_lines[v]) - 3.0 * tolerance * tolerance;
        double& length = lengths[surface.originals[v]];
        length = std::min(length, std::clamp(0.75 * std::sqrt(std::max(square, 0.0)), shortest, longest));
    }
    grade(lengths, surface.points, surface.triangles, surface.originals);
    return lengths;
}

} // namespace sinew
