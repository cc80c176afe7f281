// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/remeshing/remeshed.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace sinew {

namespace {

/// For each line of the new surface the one of the old surface on which it lies.
std::vector<int> old_lines(const Remeshed& remeshed, const Manifold& cut)
{
    std::vector<std::array<Vector3, 2>> segments;
    for (const Manifold::Line& line : cut.lines)
        segments.push_back({cut.points[line.edge[0]], cut.points[line.edge[1]]});
    std::vector<Vector3> middles;
    for (const Edge& edge : remeshed.lines)
        middles.push_back(0.5 * (remeshed.points[edge[0]] + remeshed.points[edge[1]]));
    return closest_lines(segments, middles);
}

} // namespace

void join_cuts(Remeshed& remeshed, const SurfaceMesh& mesh, const Manifold& cut)
{
    const std::vector<int> which = old_lines(remeshed, cut);
    // Vertices on cuts that are exactly in one place become one; the others keep their order.
    std::vector<char> at_cut(remeshed.points.size(), 0);
    for (std::size_t i = 0; i < which.size(); ++i)
        for (int v : remeshed.lines[i])
            at_cut[v] = at_cut[v] || which[i] < 0 || cut.lines[which[i]].cut;
    std::vector<std::array<double, 3>> pinched; // places of vertices that were there several times
    std::vector<int> copies(mesh.vertex_count(), 0);
    for (int v : cut.originals)
        ++copies[v];
    for (std::size_t v = 0; v < cut.points.size(); ++v)
        if (copies[cut.originals[v]] > 1)
            pinched.push_back({cut.points[v].x(), cut.points[v].y(), cut.points[v].z()});
    std::ranges::sort(pinched);
    std::map<std::array<double, 3>, int> joined;
    std::vector<int> numbers(remeshed.points.size());
    std::vector<Vector3> points;
    for (std::size_t v = 0; v < numbers.size(); ++v) {
        const Vector3& p = remeshed.points[v];
        const std::array place{p.x(), p.y(), p.z()};
        const auto next = static_cast<int>(points.size());
        numbers[v] = at_cut[v] || std::ranges::binary_search(pinched, place)
                         ? joined.emplace(place, next).first->second
                         : next;
        if (numbers[v] == next)
            points.push_back(p);
    }
    remeshed.points = std::move(points);
    for (Triangle& t : remeshed.triangles)
        for (int& v : t)
            v = numbers[v];
    std::erase_if(remeshed.triangles,
                  [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
    std::set<Edge> lines;
    for (const Edge& edge : remeshed.lines) {
        const auto [a, b] = std::minmax(numbers[edge[0]], numbers[edge[1]]);
        if (a != b)
            lines.insert({a, b});
    }
    remeshed.lines.assign(lines.begin(), lines.end());
}

void trace(Remeshed& remeshed, const SurfaceMesh& mesh, const Manifold& cut, const std::vector<Edge>& given,
           const Progress& progress)
{
    const std::vector<int> which = old_lines(remeshed, cut);
    std::vector<Edge> lines;
    for (std::size_t i = 0; i < which.size(); ++i)
        if (const int source = which[i] < 0 ? -1 : cut.lines[which[i]].given; source >= 0) {
            lines.push_back(remeshed.lines[i]);
            remeshed.sources.push_back(source);
        }
    remeshed.lines = std::move(lines);
    progress.tick(0.8, "carrying over");
    remeshed.origins = find_origins(mesh, given, remeshed.points, remeshed.triangles, progress);
}

} // namespace sinew
