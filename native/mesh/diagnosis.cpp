// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/diagnosis.h"

#include "native/core/report.h"
#include "native/mesh/components.h"
#include "native/mesh/half_edges.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <map>
#include <numeric>

namespace sinew {

namespace {

/// Chains the sides of the border head to tail. Where several sides leave a vertex, the loop takes the first
/// one that is unused, so every side ends up in exactly one loop.
std::vector<std::vector<int>> chain(const std::vector<HalfEdge>& border)
{
    std::multimap<int, int> outgoing;
    for (const HalfEdge& side : border)
        outgoing.emplace(side.from, side.to);
    std::vector<std::vector<int>> loops;
    while (!outgoing.empty()) {
        std::vector<int> loop;
        for (auto side = outgoing.begin(); side != outgoing.end();) {
            const int next = side->second;
            loop.push_back(side->first);
            outgoing.erase(side);
            side = outgoing.find(next);
        }
        loops.push_back(std::move(loop));
    }
    return loops;
}

/// Vertices with more than one fan of faces around them. Faces belong to one fan where they share an edge at
/// the vertex.
std::vector<int> several_fans(const SurfaceMesh& mesh, const std::vector<HalfEdge>& sides)
{
    // A union-find structure with one node per corner, joined through the two corners of every shared edge.
    std::vector<int> first_corner(mesh.face_count() + 1, 0);
    for (int f = 0; f < mesh.face_count(); ++f)
        first_corner[f + 1] = first_corner[f] + static_cast<int>(mesh.face(f).size());
    std::vector<int> parent(first_corner.back());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int c) {
        while (parent[c] != c)
            c = parent[c] = parent[parent[c]];
        return c;
    };
    const auto corner = [&](int face, int vertex) {
        const auto loop = mesh.face(face);
        return first_corner[face] + static_cast<int>(std::ranges::find(loop, vertex) - loop.begin());
    };
    for (std::size_t i = 1; i < sides.size(); ++i) {
        const HalfEdge& a = sides[i - 1];
        const HalfEdge& b = sides[i];
        if (a.low != b.low || a.high != b.high)
            continue;
        for (int v : {a.low, a.high})
            parent[root(corner(a.face, v))] = root(corner(b.face, v));
    }
    std::vector<int> fans(mesh.vertex_count(), 0);
    for (int f = 0; f < mesh.face_count(); ++f) {
        const auto loop = mesh.face(f);
        for (std::size_t k = 0; k < loop.size(); ++k) {
            const int c = first_corner[f] + static_cast<int>(k);
            if (corner(f, loop[k]) == c && root(c) == c)
                ++fans[loop[k]];
        }
    }
    std::vector<int> result;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (fans[v] > 1)
            result.push_back(v);
    return result;
}

bool is_degenerate(const SurfaceMesh& mesh, std::span<const int> loop)
{
    Vector3 area = Vector3::Zero();
    double longest = 0.0;
    const Vector3 origin = mesh.point(loop[0]);
    for (std::size_t k = 0; k < loop.size(); ++k) {
        const Vector3 a = mesh.point(loop[k]) - origin;
        const Vector3 b = mesh.point(loop[(k + 1) % loop.size()]) - origin;
        area += 0.5 * a.cross(b);
        longest = std::max(longest, (b - a).squaredNorm());
    }
    return area.norm() <= 1e-10 * longest;
}

std::vector<int> repeated_faces(const SurfaceMesh& mesh)
{
    std::vector<std::pair<std::vector<int>, int>> keys;
    for (int f = 0; f < mesh.face_count(); ++f) {
        const auto loop = mesh.face(f);
        std::vector<int> key(loop.begin(), loop.end());
        std::ranges::sort(key);
        keys.emplace_back(std::move(key), f);
    }
    std::ranges::sort(keys);
    std::vector<int> result;
    for (std::size_t i = 1; i < keys.size(); ++i)
        if (keys[i].first == keys[i - 1].first)
            result.push_back(keys[i].second);
    std::ranges::sort(result);
    return result;
}

std::vector<int> repeated_points(const SurfaceMesh& mesh)
{
    const Points& p = mesh.points();
    std::vector<int> order(mesh.vertex_count());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](int v) { return std::array{p(v, 0), p(v, 1), p(v, 2)}; };
    std::ranges::stable_sort(order, {}, key);
    std::vector<int> result;
    for (std::size_t i = 1; i < order.size(); ++i)
        if (key(order[i]) == key(order[i - 1]))
            result.push_back(order[i]);
    std::ranges::sort(result);
    return result;
}

} // namespace

Diagnosis diagnose(const SurfaceMesh& mesh)
{
    Diagnosis found;
    const std::vector<HalfEdge> sides = sorted_half_edges(mesh);
    std::vector<HalfEdge> border;
    for_each_edge(sides, [&](std::span<const HalfEdge> along) {
        if (along.size() == 1)
            border.push_back(along[0]);
        else if (along.size() > 2)
            found.non_manifold_edges.push_back(along[0].edge());
        else if (along[0].from == along[1].from)
            found.inconsistent_edges.push_back(along[0].edge());
    });
    found.boundary_loops = chain(border);
    found.non_manifold_vertices = several_fans(mesh, sides);

    std::vector<bool> used(mesh.vertex_count(), false);
    for (int f = 0; f < mesh.face_count(); ++f) {
        if (is_degenerate(mesh, mesh.face(f)))
            found.degenerate_faces.push_back(f);
        for (int v : mesh.face(f))
            used[v] = true;
    }
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (!used[v])
            found.loose_vertices.push_back(v);
    found.duplicate_faces = repeated_faces(mesh);
    found.coincident_vertices = repeated_points(mesh);
    found.component_count = connected_components(mesh).count;
    return found;
}

std::string summary(const Diagnosis& d)
{
    return summary_of({
        {d.degenerate_faces.size(), "face without area", "faces without area"},
        {d.duplicate_faces.size(), "duplicate face", "duplicate faces"},
        {d.non_manifold_edges.size(), "non-manifold edge", "non-manifold edges"},
        {d.non_manifold_vertices.size(), "non-manifold vertex", "non-manifold vertices"},
        {d.inconsistent_edges.size(), "edge between opposed faces", "edges between opposed faces"},
        {d.loose_vertices.size(), "loose vertex", "loose vertices"},
        {d.coincident_vertices.size(), "doubled vertex", "doubled vertices"},
    });
}

} // namespace sinew
