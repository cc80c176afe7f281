// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/remeshing/manifold.h"

#include "native/core/errors.h"
#include "native/mesh/components.h"
#include "native/mesh/half_edges.h"
#include "native/mesh/sheets.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <span>
#include <utility>

namespace sinew {

namespace {

constexpr double least_edges = 10.0; // of folds that are features
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

template <class Body>
void for_each_edge_of(std::span<const Side> sorted, Body&& body)
{
    for (std::size_t begin = 0, end; begin < sorted.size(); begin = end) {
        end = begin + 1;
        while (end < sorted.size() && sorted[end].edge() == sorted[begin].edge())
            ++end;
        body(sorted.subspan(begin, end - begin));
    }
}

/// Gives each fan of triangles around a vertex a vertex of its own: triangles belong to one fan where they,
/// and no third one, share an edge. Returns how many vertices there are, numbered as they come.
int part_fans(std::vector<Triangle>& triangles, std::span<const Side> sides)
{
    JoinedGroups fans(3 * static_cast<int>(triangles.size()));
    for_each_edge_of(sides, [&](std::span<const Side> along) {
        const Side &a = along.front(), &b = along.back();
        if (along.size() == 2 && a.rises != b.rises) {
            fans.join(3 * a.triangle + a.place, 3 * b.triangle + (b.place + 1) % 3);
            fans.join(3 * a.triangle + (a.place + 1) % 3, 3 * b.triangle + b.place);
        }
    });
    std::vector<int> numbers(3 * triangles.size(), -1);
    int count = 0;
    for (int c = 0; c < static_cast<int>(numbers.size()); ++c) {
        int& number = numbers[fans.lowest(c)];
        if (number < 0)
            number = count++;
        triangles[c / 3][c % 3] = number;
    }
    return count;
}

double angle_between(const Vector3& a, const Vector3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

} // namespace

Manifold::Manifold(const SurfaceMesh& mesh, const std::vector<Edge>& given) : triangles(oriented(mesh))
{
    const std::vector<Triangle> old = triangles;
    std::map<Edge, int> places; // of given edges, the first of equal ones
    for (int i = 0; i < static_cast<int>(given.size()); ++i)
        places.emplace(Edge{std::min(given[i][0], given[i][1]), std::max(given[i][0], given[i][1])}, i);

    // One vertex for each fan. New vertices part edges, too, which parts more fans, until nothing changes.
    std::vector<Side> sides = sides_of(triangles);
    std::vector<Edge> shared, crowded; // edges of the mesh with several triangles, and with more than two
    for_each_edge_of(sides, [&](std::span<const Side> along) {
        if (along.size() > 1)
            shared.push_back(along[0].edge());
        if (along.size() > 2)
            crowded.push_back(along[0].edge());
    });
    for (int count = -1, before = -2; count != before; sides = sides_of(triangles)) {
        before = count;
        count = part_fans(triangles, sides);
    }
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (int k = 0; k < 3; ++k)
            if (triangles[t][k] == static_cast<int>(points.size())) { // they are numbered as they come
                originals.push_back(old[t][k]);
                points.push_back(mesh.point(old[t][k]));
            }

    for (const Triangle& t : triangles)
        area += 0.5 * normal_of(points, t).norm();
    if (!(area > 0.0))
        throw InvalidMesh("no face has an area");

    int edges = 0;
    for_each_edge_of(sides, [&](std::span<const Side> along) {
        const Side& a = along.front();
        mean_edge += (points[a.low] - points[a.high]).norm();
        ++edges;
        const Triangle& from = old[a.triangle];
        const int one = from[a.place], other = from[(a.place + 1) % 3];
        const Edge was{std::min(one, other), std::max(one, other)};
        const auto place = places.find(was);
        const int which = place == places.end() ? -1 : place->second;
        const bool border = along.size() == 1;
        const bool cut = std::ranges::binary_search(border ? shared : crowded, was);
        if (border || cut || which >= 0)
            lines.push_back({a.edge(), which, cut});
    });
    mean_edge /= edges;
}

void Manifold::keep_lines(double angle, double length)
{
    if (!(angle > 0.0 && angle <= std::numbers::pi))
        throw InvalidOption("angle must be in (0, pi]");
    std::vector<Edge> folds;
    JoinedGroups chains(static_cast<int>(points.size()));
    for_each_edge_of(sides_of(triangles), [&](std::span<const Side> along) {
        const auto normal = [&](const Side& side) { return normal_of(points, triangles[side.triangle]); };
        if (along.size() == 2 && angle_between(normal(along[0]), normal(along[1])) > angle) {
            folds.push_back(along[0].edge());
            chains.join(along[0].low, along[0].high);
        }
    });
    const double least = least_edges * std::max(mean_edge, length);
    std::vector<double> lengths(points.size(), 0.0);
    for (const auto& [a, b] : folds)
        lengths[chains.lowest(a)] += (points[a] - points[b]).norm();
    std::erase_if(folds, [&](const Edge& fold) {
        return lengths[chains.lowest(fold[0])] < least ||
               std::ranges::binary_search(lines, fold, {}, &Line::edge);
    });
    for (const Edge& fold : folds)
        lines.push_back({fold});
    std::ranges::sort(lines, {}, &Line::edge);

    std::vector<std::vector<int>> beside(points.size());
    for (const Line& line : lines) {
        beside[line.edge[0]].push_back(line.edge[1]);
        beside[line.edge[1]].push_back(line.edge[0]);
    }
    std::vector<int> copies(*std::ranges::max_element(originals) + 1, 0);
    for (int v : originals)
        ++copies[v];
    stays.assign(points.size(), 0);
    for (std::size_t v = 0; v < points.size(); ++v) {
        const auto& ends = beside[v];
        stays[v] = copies[originals[v]] > 1 || ends.size() == 1 || ends.size() > 2 ||
                   (ends.size() == 2 &&
                    angle_between(points[v] - points[ends[0]], points[ends[1]] - points[v]) > sharpest_bend);
    }
}

std::vector<Triangle> Manifold::parted_at_lines() const
{
    std::vector<Side> sides = sides_of(triangles);
    std::erase_if(sides, [&](const Side& side) {
        return std::ranges::binary_search(lines, side.edge(), {}, &Line::edge);
    });
    std::vector<Triangle> parted = triangles;
    part_fans(parted, sides);
    return parted;
}

} // namespace sinew
