// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/frames/sides.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

namespace sinew {

namespace {

struct Side
{
    int high, face;
    bool forward; ///< whether the face runs along the edge from its lower to its higher vertex
};

/// A face across an edge, and whether it lies the other way round.
struct Neighbour
{
    int face;
    bool turned;
};

/// Calls visit(face, other, turned) for every edge of exactly two faces.
template <class Visit>
void for_each_pair(const SurfaceMesh& mesh, Visit&& visit)
{
    const auto for_each_side = [&](auto&& body) {
        for (int f = 0; f < mesh.face_count(); ++f) {
            const auto loop = mesh.face(f);
            for (std::size_t k = 0; k < loop.size(); ++k)
                if (const int a = loop[k], b = loop[k + 1 == loop.size() ? 0 : k + 1]; a != b)
                    body(std::min(a, b), Side{std::max(a, b), f, a < b});
        }
    };
    // Side by side at their lower vertex, where there are few.
    std::vector<int> end(mesh.vertex_count() + 1, 0);
    for_each_side([&](int low, const Side&) { ++end[low + 1]; });
    std::partial_sum(end.begin(), end.end(), end.begin());
    std::vector<Side> sides(end.back());
    std::vector<int> next(end.begin(), end.end() - 1);
    for_each_side([&](int low, const Side& side) { sides[next[low]++] = side; });
    for (int low = 0; low < mesh.vertex_count(); ++low) {
        const auto here = std::span(sides).subspan(end[low], end[low + 1] - end[low]);
        std::ranges::sort(here, {}, [](const Side& s) { return std::pair(s.high, s.face); });
        for (std::size_t first = 0, last; first < here.size(); first = last) {
            for (last = first + 1; last < here.size() && here[last].high == here[first].high;)
                ++last;
            const Side &one = here[first], &other = here[last - 1];
            if (last - first == 2 && one.face != other.face)
                visit(one.face, other.face, one.forward == other.forward);
        }
    }
}

/// Whether each face lies the other way round than the larger area of those that it is joined to.
std::vector<char> turned_faces(const SurfaceMesh& mesh)
{
    std::vector<char> turned(mesh.face_count(), 0);
    bool any = false;
    for_each_pair(mesh, [&](int, int, bool is_turned) { any |= is_turned; });
    if (!any)
        return turned;
    std::vector<std::vector<Neighbour>> neighbours(mesh.face_count());
    for_each_pair(mesh, [&](int one, int other, bool is_turned) {
        neighbours[one].push_back({other, is_turned});
        neighbours[other].push_back({one, is_turned});
    });
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
