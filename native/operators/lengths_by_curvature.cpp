// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/lengths_by_curvature.h"

#include "native/core/errors.h"
#include "native/mesh/remeshing/manifold.h"
#include "native/operators/curvature.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <queue>
#include <utility>
#include <vector>

namespace sinew {

namespace {

constexpr double steepest = 0.5; ///< rise of the length along an edge

/// The surface with a vertex of its own for each side of a fold at which several vertices can be told apart.
struct Parted
{
    std::vector<int> vertices; ///< of the surface, for each vertex here
    std::vector<int> corners;

    explicit Parted(const Manifold& surface)
    {
        std::map<Edge, int> first; // the side of a triangle that comes first at each edge that is no line
        for (const Manifold::Line& line : surface.lines)
            first.emplace(line.edge, -1);
        std::vector<int> parent(3 * surface.triangles.size());
        std::iota(parent.begin(), parent.end(), 0);
        const auto root = [&](int c) {
            while (parent[c] != c)
                c = parent[c] = parent[parent[c]];
            return c;
        };
        for (int side = 0; side < static_cast<int>(parent.size()); ++side) {
            const Triangle& t = surface.triangles[side / 3];
            const auto [low, high] = std::minmax(t[side % 3], t[(side + 1) % 3]);
            const auto [at, is_new] = first.emplace(Edge{low, high}, side);
            if (is_new || at->second < 0)
                continue;
            for (int end : {0, 1}) {
                const int one = root(side / 3 * 3 + (side % 3 + end) % 3);
                const int other = root(at->second / 3 * 3 + (at->second % 3 + 1 - end) % 3);
                parent[std::max(one, other)] = std::min(one, other);
            }
        }
        std::vector<int> numbers(parent.size(), -1);
        for (int c = 0; c < static_cast<int>(parent.size()); ++c) {
            int& number = numbers[root(c)];
            if (number < 0) {
                number = static_cast<int>(vertices.size());
                vertices.push_back(surface.triangles[c / 3][c % 3]);
            }
            corners.push_back(number);
        }
    }
};

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
    const Manifold surface(mesh, {}, options.angle);
    const Parted parted(surface);
    Points points(parted.vertices.size(), 3);
    for (Eigen::Index v = 0; v < points.rows(); ++v)
        points.row(v) = surface.points[parted.vertices[v]].transpose();
    const std::vector<int> counts(surface.triangles.size(), 3);
    const Curvature found = curvature(SurfaceMesh(std::move(points), counts, parted.corners));
    std::vector<double> bends = bends_of_lines(surface);
    for (std::size_t v = 0; v < parted.vertices.size(); ++v)
        for (const VectorX& principal : found.principal)
            bends[parted.vertices[v]] = std::max(bends[parted.vertices[v]], std::abs(principal[v]));

    VectorX lengths = VectorX::Constant(mesh.vertex_count(), longest);
    for (std::size_t v = 0; v < bends.size(); ++v) {
        const double square = 6.0 * tolerance / bends[v] - 3.0 * tolerance * tolerance;
        double& length = lengths[surface.originals[v]];
        length = std::min(length, std::clamp(0.75 * std::sqrt(std::max(square, 0.0)), shortest, longest));
    }
    grade(lengths, surface.points, surface.triangles, surface.originals);
    return lengths;
}

} // namespace sinew
