// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/caging/quads.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

namespace sinew {

namespace {

/// Corners a, q, b, p of two triangles (a, b, p) and (b, a, q).
struct Pair
{
    double badness;
    int first, second; ///< triangles
    std::array<int, 4> loop;

    std::pair<int, int> other_diagonal() const { return std::minmax(loop[1], loop[3]); }
    std::array<Triangle, 2> other_cut() const
    {
        return {Triangle{loop[0], loop[1], loop[3]}, Triangle{loop[1], loop[2], loop[3]}};
    }
};

Vector3 normal(const Corners& t) { return (t[1] - t[0]).cross(t[2] - t[0]).normalized(); }

/// The largest cosine among the angles of a quad, or 2 where it is not convex or bent by more than 45
/// degrees.
double badness(const std::vector<Vector3>& points, const std::array<int, 4>& loop)
{
    constexpr double least = 0.7;
    const auto corner = [&](int k) -> const Vector3& { return points[loop[k % 4]]; };
    Vector3 area = Vector3::Zero();
    for (int k = 0; k < 4; ++k)
        area += corner(k).cross(corner(k + 1));
    area.normalize();
    double worst = 0.0;
    for (int k = 0; k < 4; ++k) {
        const Vector3 in = corner(k + 3) - corner(k), out = corner(k + 1) - corner(k);
        if (normal({corner(k), corner(k + 1), corner(k + 3)}).dot(area) < least)
            return 2.0;
        worst = std::max(worst, std::abs(in.dot(out)) / (in.norm() * out.norm()));
    }
    return worst;
}

/// Whether points of a triangle, spaced by a fourth of its sides, are at least `apart` away.
bool is_away(const Corners& t, const TriangleTree& from, double apart)
{
    for (int i = 0; i <= 4; ++i)
        for (int j = 0; i + j <= 4; ++j) {
            const Vector3 p = t[0] + 0.25 * i * (t[1] - t[0]) + 0.25 * j * (t[2] - t[0]);
            if ((from.closest(p) - p).norm() < apart)
                return false;
        }
    return true;
}

std::vector<Pair> candidates(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles)
{
    std::map<std::pair<int, int>, std::pair<int, int>> half_edges; // (from, to) -> triangle, apex
    for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
        for (int k = 0; k < 3; ++k)
            half_edges[{triangles[t][k], triangles[t][(k + 1) % 3]}] = {t, triangles[t][(k + 2) % 3]};
    std::vector<Pair> pairs;
    for (const auto& [edge, first] : half_edges) {
        const auto other = half_edges.find({edge.second, edge.first});
        if (edge.first > edge.second || other == half_edges.end())
            continue;
        const std::array loop{edge.first, other->second.second, edge.second, first.second};
        if (const double bad = badness(points, loop); bad < 0.85) // angles of 32 to 148 degrees
            pairs.push_back({bad, first.first, other->second.first, loop});
    }
    std::ranges::sort(pairs, {}, [](const Pair& p) { return std::tuple(p.badness, p.first, p.second); });
    return pairs;
}

} // namespace

Polygons polygons(const std::vector<Triangle>& triangles)
{
    Polygons faces;
    for (const Triangle& t : triangles)
        faces.emplace_back(t.begin(), t.end());
    return faces;
}

Polygons paired(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles,
                const TriangleTree& within, double apart, int mirror_axis)
{
    struct Cut
    {
        Triangle indices;
        int first, second; ///< the triangles that it replaces
    };
    std::vector<Cut> cuts; // all triangles that the result may be cut into, along either diagonal
    for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
        cuts.push_back({triangles[t], t, t});

    const auto is_free = [&](const Triangle& indices, const Pair& pair) {
        const Corners corners = corners_of(points, indices);
        return !is_flat(corners) && !within.meets(corners) && is_away(corners, within, apart) &&
               std::ranges::none_of(cuts, [&](const Cut& cut) {
                   const bool replaced = cut.first == pair.first || cut.first == pair.second ||
                                         cut.second == pair.first || cut.second == pair.second;
                   return !replaced &&
                          triangles_meet(corners, indices, corners_of(points, cut.indices), cut.indices);
               });
    };
    std::set<std::pair<int, int>> taken; // edges, and diagonals of quads
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k)
            taken.insert(std::minmax(t[k], t[(k + 1) % 3]));
    const auto on_mirror = [&](int v) { return mirror_axis >= 0 && points[v][mirror_axis] == 0.0; };
    const auto is_crowded =
        [&](const Pair& pair) { // the image of the quad has the same diagonal on the mirror
            return taken.contains(pair.other_diagonal()) ||
                   (on_mirror(pair.loop[1]) && on_mirror(pair.loop[3]));
        };
    std::vector<const Pair*> joined(triangles.size(), nullptr);
    const std::vector<Pair> pairs = candidates(points, triangles);
    for (const Pair& pair : pairs) {
        const auto other = pair.other_cut();
        if (joined[pair.first] || joined[pair.second] || is_crowded(pair) || !is_free(other[0], pair) ||
            !is_free(other[1], pair))
            continue;
        taken.insert(pair.other_diagonal());
        joined[pair.first] = joined[pair.second] = &pair;
        for (const Triangle& indices : other)
            cuts.push_back({indices, pair.first, pair.second});
    }
    Polygons faces;
    for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
        if (!joined[t])
            faces.emplace_back(triangles[t].begin(), triangles[t].end());
        else if (t == std::min(joined[t]->first, joined[t]->second))
            faces.emplace_back(joined[t]->loop.begin(), joined[t]->loop.end());
    }
    return faces;
}

} // namespace sinew
