// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/diagnosis.h"

#include "native/core/report.h"
#include "native/mesh/components.h"
#include "native/mesh/half_edges.h"
#include "native/mesh/sheets.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace sinew {

namespace {

/// Chains the sides of the border head to tail, and where faces are flipped also tail to tail. Where several
/// sides leave a vertex, the loop takes the first one that is unused, so every side ends up in one loop.
std::vector<std::vector<int>> chain(const std::vector<HalfEdge>& border)
{
    std::multimap<int, int> outgoing, incoming;
    for (int side = 0; side < static_cast<int>(border.size()); ++side) {
        outgoing.emplace(border[side].from, side);
        incoming.emplace(border[side].to, side);
    }
    std::vector<char> used(border.size(), 0);
    const auto unused_side = [&](const std::multimap<int, int>& sides, int v) {
        const auto [begin, end] = sides.equal_range(v);
        const auto found = std::find_if(begin, end, [&](const auto& side) { return !used[side.second]; });
        return found == end ? -1 : found->second;
    };
    std::vector<std::vector<int>> loops;
    for (const auto& [start, first] : outgoing) {
        if (used[first])
            continue;
        std::vector<int> loop;
        for (int v = start;;) {
            const int ahead = unused_side(outgoing, v), side = ahead >= 0 ? ahead : unused_side(incoming, v);
            if (side < 0)
                break;
            loop.push_back(std::exchange(v, side == ahead ? border[side].to : border[side].from));
            used[side] = 1;
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

/// (n) of each vertex the one of the lowest index that is exactly where it is.
std::vector<int> places(const SurfaceMesh& mesh)
{
    const Points& p = mesh.points();
    std::vector<int> order(mesh.vertex_count()), place(order.size());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](int v) { return std::array{p(v, 0), p(v, 1), p(v, 2)}; };
    std::ranges::stable_sort(order, {}, key);
    for (std::size_t i = 0; i < order.size(); ++i)
        place[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? place[order[i - 1]] : order[i];
    return place;
}

std::vector<std::array<int, 2>> slits(const std::vector<HalfEdge>& border, const std::vector<int>& place)
{
    std::vector<std::pair<std::array<int, 2>, std::array<int, 2>>> edges; // where it is, and which
    for (const HalfEdge& side : border) {
        const auto [a, b] = std::minmax(place[side.low], place[side.high]);
        if (a != b)
            edges.push_back({{a, b}, side.edge()});
    }
    std::ranges::sort(edges);
    std::vector<std::array<int, 2>> found;
    for (std::size_t i = 0; i < edges.size(); ++i)
        if ((i > 0 && edges[i - 1].first == edges[i].first) ||
            (i + 1 < edges.size() && edges[i + 1].first == edges[i].first))
            found.push_back(edges[i].second);
    std::ranges::sort(found);
    return found;
}

/// See Diagnosis.
std::vector<int> flipped(const SurfaceMesh& mesh, const std::vector<Sheet>& found)
{
    std::vector<int> faces;
    std::vector<Eigen::AlignedBox3d> boxes(found.size());
    for (std::size_t s = 0; s < found.size(); ++s)
        if (found[s].closed)
            for (int f : found[s].faces)
                for (int v : mesh.face(f))
                    boxes[s].extend(mesh.point(v));
    std::vector<int> end(mesh.face_count(), 0); // of the triangles of each face, which follow one another
    for (std::size_t t = 0; t < mesh.triangles().size(); ++t)
        end[mesh.triangle_faces()[t]] = static_cast<int>(t) + 1;
    for (std::size_t s = 0; s < found.size(); ++s) {
        const auto& [members, turned, closed, one_sided] = found[s];
        if (one_sided)
            continue;
        const Vector3 origin = mesh.point(mesh.face(members.front()).front());
        double volume = 0.0, area = 0.0; // of the faces as the first one looks; of those less the others
        for (std::size_t k = 0; k < members.size(); ++k)
            for (int at = members[k] > 0 ? end[members[k] - 1] : 0; at < end[members[k]]; ++at) {
                const Triangle& t = mesh.triangles()[at];
                const Vector3 a = mesh.point(t[0]) - origin, b = mesh.point(t[1]) - origin;
                const Vector3 c = mesh.point(t[2]) - origin, normal = (b - a).cross(c - a);
                volume += (turned[k] ? -1.0 : 1.0) * a.dot(normal);
                area += (turned[k] ? -1.0 : 1.0) * normal.norm();
            }
        const auto holds = [&](const auto& box) { return &box != &boxes[s] && box.contains(boxes[s]); };
        bool first_is_wrong = area < 0.0;
        if (closed && (volume < 0.0) != first_is_wrong && std::ranges::none_of(boxes, holds))
            first_is_wrong = !first_is_wrong;
        for (std::size_t k = 0; k < members.size(); ++k)
            if ((turned[k] != 0) != first_is_wrong)
                faces.push_back(members[k]);
    }
    std::ranges::sort(faces);
    return faces;
}

} // namespace

Diagnosis diagnose(const SurfaceMesh& mesh)
{
    Diagnosis found;
    const std::vector<HalfEdge> sides = sorted_half_edges(mesh);
    std::vector<HalfEdge> border;
    int edges = 0;
    for_each_edge(sides, [&](std::span<const HalfEdge> along) {
        ++edges;
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
    const std::vector<int> place = places(mesh);
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (place[v] != v)
            found.coincident_vertices.push_back(v);
    found.slit_edges = slits(border, place);
    const std::vector<Sheet> parts = sheets(mesh, sides);
    found.flipped_faces = flipped(mesh, parts);
    std::erase_if(found.flipped_faces, [&](int f) {
        return std::ranges::binary_search(found.degenerate_faces, f) ||
               std::ranges::binary_search(found.duplicate_faces, f);
    });
    found.one_sided_count = static_cast<int>(std::ranges::count_if(parts, &Sheet::one_sided));
    found.component_count = connected_components(mesh).count;
    found.euler_characteristic = static_cast<int>(std::ranges::count(used, true)) - edges + mesh.face_count();
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
        {d.flipped_faces.size(), "flipped face", "flipped faces"},
        {d.slit_edges.size(), "edge of a slit", "edges of slits"},
        {d.loose_vertices.size(), "loose vertex", "loose vertices"},
        {d.coincident_vertices.size(), "doubled vertex", "doubled vertices"},
    });
}

} // namespace sinew
