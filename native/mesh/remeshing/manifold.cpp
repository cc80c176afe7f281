// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/remeshing/manifold.h"

#include "native/mesh/half_edges.h"
#include "native/mesh/sheets.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

namespace sinew {

namespace {

constexpr double sharpest_bend = 75.0 * std::numbers::pi / 180.0;

struct Side
{
    int low, high, triangle, place; ///< from corner `place` of the triangle to the next
    bool rises; ///< from the lower vertex to the higher one

    Edge edge() const { return {low, high}; }
};

std::vector<Side> sides_of(const std::vector<Triangle>& triangles)
{
    std::vector<Side> sides;
    sides.reserve(3 * triangles.size());
    for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
        for (int k = 0; k < 3; ++k) {
            const int a = triangles[t][k], b = triangles[t][(k + 1) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), t, k, a < b});
        }
    std::ranges::stable_sort(sides, {}, &Side::edge);
    return sides;
}

/// The triangles, most of each sheet as they are, without duplicates.
std::vector<Triangle> oriented(const SurfaceMesh& mesh)
{
    std::vector<char> turned(mesh.face_count(), 0);
    for (const Sheet& sheet : sheets(mesh, sorted_half_edges(mesh))) {
        const auto count = static_cast<std::size_t>(std::ranges::count(sheet.turned, 1));
        const bool most = 2 * count > sheet.turned.size();
        for (std::size_t k = 0; k < sheet.faces.size() && !sheet.one_sided; ++k)
            turned[sheet.faces[k]] = (sheet.turned[k] != 0) != most;
    }
    std::vector<std::pair<Triangle, int>> keys;
    for (int t = 0; t < static_cast<int>(mesh.triangles().size()); ++t) {
        Triangle key = mesh.triangles()[t];
        std::ranges::sort(key);
        if (key[0] != key[1] && key[1] != key[2])
            keys.emplace_back(key, t);
    }
    std::ranges::sort(keys);
    std::vector<int> kept;
    for (std::size_t i = 0; i < keys.size(); ++i)
        if (i == 0 || keys[i].first != keys[i - 1].first)
            kept.push_back(keys[i].second);
    std::ranges::sort(kept);
    std::vector<Triangle> triangles;
    for (int t : kept) {
        triangles.push_back(mesh.triangles()[t]);
        if (turned[mesh.triangle_faces()[t]])
            std::swap(triangles.back()[1], triangles.back()[2]);
    }
    return triangles;
}

Vector3 normal_of(const std::vector<Vector3>& points, const Triangle& t)
{
    return (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
}

double angle_between(const Vector3& a, const Vector3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

} // namespace

double area_of(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles)
{
    double area = 0.0;
    for (const Triangle& t : triangles)
        area += 0.5 * normal_of(points, t).norm();
    return area;
}

double mean_edge_length(const Manifold& manifold)
{
    double sum = 0.0;
    int count = 0;
    const std::vector<Side> sides = sides_of(manifold.triangles);
    for (std::size_t i = 0; i < sides.size(); ++i)
        if (i == 0 || sides[i].edge() != sides[i - 1].edge()) {
            sum += (manifold.points[sides[i].low] - manifold.points[sides[i].high]).norm();
            ++count;
        }
    return count > 0 ? sum / count : 0.0;
}

Manifold::Manifold(const SurfaceMesh& mesh, const std::vector<Edge>& given, double angle)
{
    triangles = oriented(mesh);
    std::map<Edge, int> places; // of given edges, the first of equal ones
    for (int i = 0; i < static_cast<int>(given.size()); ++i)
        places.emplace(Edge{std::min(given[i][0], given[i][1]), std::max(given[i][0], given[i][1])}, i);

    // One vertex for each fan: corners are one where two triangles, and no third one, share an edge.
    std::vector<int> parent(3 * triangles.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int c) {
        while (parent[c] != c)
            c = parent[c] = parent[parent[c]];
        return c;
    };
    const auto join = [&](int a, int b) {
        a = root(a), b = root(b);
        parent[std::max(a, b)] = std::min(a, b);
    };
    const std::vector<Side> sides = sides_of(triangles);
    struct Found
    {
        Side side;
        int given;
        bool cut, border;
    };
    std::vector<Found> found;
    for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
        end = begin + 1;
        while (end < sides.size() && sides[end].edge() == sides[begin].edge())
            ++end;
        const Side &a = sides[begin], &b = sides[end - 1];
        const bool whole = end - begin == 2 && a.rises != b.rises;
        const auto place = places.find(a.edge());
        const int which = place == places.end() ? -1 : place->second;
        if (!whole) {
            for (std::size_t i = begin; i < end; ++i)
                found.push_back({sides[i], which, end - begin > 1, true});
            continue;
        }
        join(3 * a.triangle + a.place, 3 * b.triangle + (b.place + 1) % 3);
        join(3 * a.triangle + (a.place + 1) % 3, 3 * b.triangle + b.place);
        bool fold = which >= 0;
        if (!fold) {
            const auto normal = [&](const Side& s) {
                const Triangle& t = triangles[s.triangle];
                return Vector3(
                    (mesh.point(t[1]) - mesh.point(t[0])).cross(mesh.point(t[2]) - mesh.point(t[0])));
            };
            fold = angle_between(normal(a), normal(b)) > angle;
        }
        if (fold)
            found.push_back({a, which, false, false});
    }
    std::vector<int> numbers(parent.size(), -1);
    for (int c = 0; c < static_cast<int>(parent.size()); ++c) {
        int& number = numbers[root(c)];
        if (number < 0) {
            number = static_cast<int>(points.size());
            originals.push_back(triangles[c / 3][c % 3]);
            points.push_back(mesh.point(originals.back()));
        }
    }
    for (int c = 0; c < static_cast<int>(parent.size()); ++c)
        triangles[c / 3][c % 3] = numbers[root(c)];
    stays.assign(points.size(), 0);
    std::vector<std::vector<int>> beside(points.size());
    for (const auto& [side, which, cut, border] : found) {
        const Triangle& t = triangles[side.triangle];
        const Edge edge{t[side.place], t[(side.place + 1) % 3]};
        lines.push_back({edge, which, cut});
        beside[edge[0]].push_back(edge[1]);
        beside[edge[1]].push_back(edge[0]);
    }
    for (std::size_t v = 0; v < points.size(); ++v) {
        const auto& ends = beside[v];
        stays[v] = ends.size() == 1 || ends.size() > 2 ||
                   (ends.size() == 2 &&
                    angle_between(points[v] - points[ends[0]], points[ends[1]] - points[v]) > sharpest_bend);
    }
    // The copies of a vertex must stay together.
    std::vector<int> copies(mesh.vertex_count(), 0);
    for (int v : originals)
        ++copies[v];
    for (std::size_t v = 0; v < points.size(); ++v)
        stays[v] = stays[v] || copies[originals[v]] > 1;
}

} // namespace sinew
