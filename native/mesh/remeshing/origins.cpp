// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/remeshing/origins.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/mesh/trees/box_tree.h"
#include "native/mesh/trees/closest_triangle.h"
#include "native/mesh/trees/triangle_tree.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>
#include <queue>
#include <utility>

namespace sinew {

namespace {

constexpr int grain = 512;
constexpr int patience = 64; ///< triangles that are looked at without finding a closer one

/// Barycentric coordinates of the point of a triangle that is closest in its plane, made to lie inside.
Vector3 weights_in(const Corners& t, const Vector3& p)
{
    const Vector3 u = t[1] - t[0], v = t[2] - t[0], w = p - t[0];
    const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), wu = w.dot(u), wv = w.dot(v);
    const double determinant = uu * vv - uv * uv;
    Vector3 found(1.0, 0.0, 0.0);
    if (determinant > 0.0) {
        const double b = (vv * wu - uv * wv) / determinant, c = (uu * wv - uv * wu) / determinant;
        found = {1.0 - b - c, b, c};
    }
    // Outside, the closest point lies on the side that is nearest.
    if (found.minCoeff() < 0.0) {
        double best = std::numeric_limits<double>::infinity();
        for (int k = 0; k < 3; ++k) {
            const Vector3 &from = t[k], along = t[(k + 1) % 3] - t[k];
            const double length = along.squaredNorm();
            const double share = length > 0.0 ? std::clamp((p - from).dot(along) / length, 0.0, 1.0) : 0.0;
            if (const double d = (from + share * along - p).squaredNorm(); d < best) {
                best = d;
                found.setZero();
                found[k] = 1.0 - share;
                found[(k + 1) % 3] = share;
            }
        }
    }
    return found;
}

/// The triangles of a mesh and which lie beside which, but for those beyond given lines.
class Islands
{
public:
    Islands(const SurfaceMesh& mesh, const std::vector<Edge>& given, const std::vector<Vector3>& points)
        : points_(points), triangles_(mesh.triangles()), beside_(triangles_.size(), {-1, -1, -1})
    {
        struct Side
        {
            Edge edge;
            int triangle, place;
        };
        std::vector<Side> sides;
        std::vector<Edge> closed = given;
        for (Edge& edge : closed)
            edge = {std::min(edge[0], edge[1]), std::max(edge[0], edge[1])};
        std::ranges::sort(closed);
        for (int t = 0; t < static_cast<int>(triangles_.size()); ++t)
            for (int k = 0; k < 3; ++k) {
                const int a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
                sides.push_back({{std::min(a, b), std::max(a, b)}, t, k});
            }
        std::ranges::stable_sort(sides, {}, &Side::edge);
        for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
            const Side &a = sides[i], &b = sides[i + 1];
            const auto same = [&](std::size_t j) { return j < sides.size() && sides[j].edge == a.edge; };
            if (b.edge == a.edge && !same(i + 2) && (i == 0 || !same(i - 1)) &&
                !std::ranges::binary_search(closed, a.edge)) {
                beside_[a.triangle][a.place] = b.triangle;
                beside_[b.triangle][b.place] = a.triangle;
            }
        }
    }

    double distance(const Vector3& p, int t) const
    {
        const Corners corners = corners_of(points_, triangles_[t]);
        return squared_distance(p, corners[0], corners[1], corners[2]);
    }

    /// The triangle closest to a point that is reached from another one; `enough`: any as close as that.
    int closest(const Vector3& p, int from, double enough) const
    {
        using Entry = std::pair<double, int>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
        std::vector<int> seen{from};
        double least = distance(p, from);
        open.emplace(least, from);
        int best = from;
        for (int idle = 0; !open.empty() && least > enough && idle < patience; ++idle) {
            const int at = open.top().second;
            open.pop();
            for (int next : beside_[at]) {
                if (next < 0 || std::ranges::find(seen, next) != seen.end())
                    continue;
                seen.push_back(next);
                const double d = distance(p, next);
                if (!std::isfinite(d))
                    continue;
                open.emplace(d, next);
                if (d < least) {
                    least = d;
                    best = next;
                    idle = 0;
                }
            }
        }
        return best;
    }

private:
    const std::vector<Vector3>& points_;
    const std::vector<Triangle>& triangles_;
    std::vector<std::array<int, 3>> beside_;
};

Vector3 centroid(const std::vector<Vector3>& points, const Triangle& t)
{
    return (points[t[0]] + points[t[1]] + points[t[2]]) / 3.0;
}

/// How far the vertices and centroids of one surface are from another one, at most.
double farthest_from(const TriangleTree& tree, const std::vector<Vector3>& points,
                     const std::vector<Triangle>& triangles)
{
    std::vector<double> distances(triangles.size());
    parallel_for(
        static_cast<int>(triangles.size()),
        [&](int t) {
            for (int k = 0; k < 4; ++k) {
                const Vector3 p = k == 3 ? centroid(points, triangles[t]) : points[triangles[t][k]];
                if (k == 3 || k == t % 3) // each vertex about twice
                    distances[t] = std::max(distances[t], (tree.closest(p) - p).norm());
            }
        },
        grain);
    return distances.empty() ? 0.0 : std::ranges::max(distances);
}

} // namespace

Origins find_origins(const SurfaceMesh& mesh, const std::vector<Edge>& given,
                     const std::vector<Vector3>& points, const std::vector<Triangle>& triangles,
                     const Progress& progress)
{
    std::vector<Vector3> old(mesh.vertex_count());
    for (int v = 0; v < mesh.vertex_count(); ++v)
        old[v] = mesh.point(v);
    const TriangleTree tree(old, mesh.triangles()), made(points, triangles);
    if (tree.empty() || made.empty())
        throw InvalidMesh("no face has an area");
    const int n = static_cast<int>(points.size()), m = static_cast<int>(triangles.size());
    Origins found;
    found.vertices.resize(n);
    found.vertex_weights.resize(n);
    std::vector<int> hosts(n);
    std::vector<double> distances(n);
    parallel_for(
        n,
        [&](int v) {
            const auto place = tree.closest_place(points[v]);
            hosts[v] = place.triangle;
            found.vertices[v] = mesh.triangles()[place.triangle];
            found.vertex_weights[v] = weights_in(corners_of(old, found.vertices[v]), place.point);
            distances[v] = (place.point - points[v]).norm();
        },
        grain);
    progress.tick(0.85, "carrying over");
    std::vector<int> first(mesh.face_count() + 1, 0); // corner of each face
    for (int f = 0; f < mesh.face_count(); ++f)
        first[f + 1] = first[f] + static_cast<int>(mesh.face(f).size());
    const Islands islands(mesh, given, old);
    found.faces.resize(m);
    found.corners.resize(3 * triangles.size());
    found.corner_weights.resize(3 * triangles.size());
    std::vector<double> heights(m); // of the centroids
    parallel_for(
        m,
        [&](int f) {
            const Vector3 middle = centroid(points, triangles[f]);
            const auto centre = tree.closest_place(middle);
            heights[f] = (centre.point - middle).norm();
            found.faces[f] = mesh.triangle_faces()[centre.triangle];
            for (int k = 0; k < 3; ++k) {
                const int v = triangles[f][k];
                int host = hosts[v];
                if (!given.empty()) {
                    const double enough =
                        distances[v] * distances[v] + 1e-20 * (middle - points[v]).squaredNorm();
                    host = islands.closest(points[v], centre.triangle, enough * (1.0 + 1e-9));
                }
                const Triangle& t = mesh.triangles()[host];
                const auto loop = mesh.face(mesh.triangle_faces()[host]);
                for (int i = 0; i < 3; ++i)
                    found.corners[3 * f + k][i] =
                        first[mesh.triangle_faces()[host]] +
                        static_cast<int>(std::ranges::find(loop, t[i]) - loop.begin());
                found.corner_weights[3 * f + k] = weights_in(corners_of(old, t), points[v]);
            }
        },
        grain);
    progress.tick(0.95, "measuring");
    double sum = 0.0;
    for (double d : distances)
        sum += d;
    found.mean = n > 0 ? sum / n : 0.0;
    found.farthest = std::max({farthest_from(made, old, mesh.triangles()), std::ranges::max(distances),
                               m > 0 ? std::ranges::max(heights) : 0.0});
    return found;
}

Vector3 closest_on(const std::array<Vector3, 2>& segment, const Vector3& point)
{
    const Vector3 along = segment[1] - segment[0];
    const double length = along.squaredNorm();
    return segment[0] +
           (length > 0.0 ? std::clamp((point - segment[0]).dot(along) / length, 0.0, 1.0) : 0.0) * along;
}

std::vector<int> closest_lines(const std::vector<std::array<Vector3, 2>>& lines,
                               const std::vector<Vector3>& points)
{
    std::vector<BoxTree::Box> boxes;
    for (const auto& [a, b] : lines)
        boxes.emplace_back(a.cwiseMin(b), a.cwiseMax(b));
    const BoxTree tree(boxes);
    std::vector<int> found(points.size(), -1);
    parallel_for(
        static_cast<int>(points.size()),
        [&](int i) {
            double least = std::numeric_limits<double>::infinity();
            tree.visit_by_bound(
                static_cast<int>(lines.size()), least,
                [&](const BoxTree::Box& box, bool) { return box.squaredExteriorDistance(points[i]); },
                [&](int line) {
                    const double d = (closest_on(lines[line], points[i]) - points[i]).squaredNorm();
                    if (d < least || (d == least && line < found[i])) {
                        least = d;
                        found[i] = line;
                    }
                    return least;
                });
        },
        grain);
    return found;
}

} // namespace sinew
