// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/frames/sides.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <tuple>
#include <vector>

namespace sinew {

namespace {

struct Side
{
    int low, high, face;
    bool forward; ///< whether the face runs along the edge from low to high
};

/// A face across an edge, and whether it lies the other way round.
struct Neighbour
{
    int face;
    bool turned;
};

/// Of each face those with which it alone shares an edge.
std::vector<std::vector<Neighbour>> neighbours_of(const SurfaceMesh& mesh)
{
    std::vector<Side> sides;
    for (int f = 0; f < mesh.face_count(); ++f) {
        const auto loop = mesh.face(f);
        for (std::size_t k = 0; k < loop.size(); ++k)
            if (const int a = loop[k], b = loop[(k + 1) % loop.size()]; a != b)
                sides.push_back({std::min(a, b), std::max(a, b), f, a < b});
    }
    std::ranges::sort(sides, {}, [](const Side& s) { return std::tuple(s.low, s.high, s.face); });
    std::vector<std::vector<Neighbour>> found(mesh.face_count());
    for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
        const Side &one = sides[begin], &other = sides[std::min(begin + 1, sides.size() - 1)];
        for (end = begin + 1; end < sides.size() && sides[end].low == one.low && sides[end].high == one.high;)
            ++end;
        if (end - begin != 2 || one.face == other.face)
            continue;
        const bool turned = one.forward == other.forward;
        found[one.face].push_back({other.face, turned});
        found[other.face].push_back({one.face, turned});
    }
    return found;
}

/// Whether each face lies the other way round than the larger area of those that it is joined to.
std::vector<char> turned_faces(const SurfaceMesh& mesh)
{
    const std::vector<std::vector<Neighbour>> neighbours = neighbours_of(mesh);
    std::vector<char> turned(mesh.face_count(), 0);
    if (std::ranges::none_of(neighbours, [](const auto& own) {
            return std::ranges::any_of(own, [](const Neighbour& n) { return n.turned; });
        }))
        return turned;
    std::vector<double> area(mesh.face_count(), 0.0);
    for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
        const auto [a, b, c] = mesh.triangles()[t];
        area[mesh.triangle_faces()[t]] +=
            (mesh.point(b) - mesh.point(a)).cross(mesh.point(c) - mesh.point(a)).norm();
    }
    std::vector<char> seen(mesh.face_count(), 0);
    for (int first = 0; first < mesh.face_count(); ++first) {
        if (seen[first])
            continue;
        std::vector<int> joined{first};
        seen[first] = 1;
        bool has_two_sides = true;
        double areas[2] = {0.0, 0.0};
        for (std::size_t k = 0; k < joined.size(); ++k) {
            const int face = joined[k];
            areas[turned[face] ? 1 : 0] += area[face];
            for (const Neighbour& next : neighbours[face]) {
                const char side = next.turned ? !turned[face] : turned[face];
                if (seen[next.face]) {
                    has_two_sides &= turned[next.face] == side;
                    continue;
                }
                seen[next.face] = 1;
                turned[next.face] = side;
                joined.push_back(next.face);
            }
        }
        for (const int face : joined)
            turned[face] = has_two_sides && turned[face] != (areas[1] > areas[0]);
    }
    return turned;
}

} // namespace

SurfaceMesh with_sides_of_the_whole(const SurfaceMesh& mesh)
{
    const std::vector<char> turned = turned_faces(mesh);
    if (std::ranges::none_of(turned, [](char each) { return each != 0; }))
        return mesh;
    std::vector<int> counts, corners;
    for (int f = 0; f < mesh.face_count(); ++f) {
        const auto face = mesh.face(f);
        counts.push_back(static_cast<int>(face.size()));
        corners.insert(corners.end(), face.begin(), face.end());
        if (turned[f]) // the first corner stays, by which a quad is cut
            std::reverse(corners.end() - counts.back() + 1, corners.end());
    }
    return {mesh.points(), std::move(counts), std::move(corners)};
}

} // namespace sinew
