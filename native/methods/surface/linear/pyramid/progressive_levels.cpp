// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/pyramid/progressive_levels.h"

#include "native/mesh/frames/surface_frame.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_set>
#include <utility>

namespace sinew {

namespace {

/// A new triangle leans less than 75 degrees against the fan that it replaces.
constexpr double least_cosine = 0.25;

/// It is no sliver: its height is this share of its longest edge, or half of the worst one that it replaces.
constexpr double least_shape = 0.1;

/// Fans whose shapes differ by less than this share are alike, and so are shortest edges in the same one of
/// four steps per octave: of those, the places of vertices decide, and neither their numbers nor rounding.
constexpr double alike = 1e-4;
constexpr double steps_per_octave = 4;

bool has_corner_twice(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// Removes one set of vertices that are no neighbours from a level.
class Coarsening
{
public:
    /// \param ranks  (n) where the places of two vertices say nothing else, that of the lower rank comes
    /// first.
    Coarsening(const Points& points, const std::vector<int>& ranks, const std::vector<Triangle>& triangles)
        : points_(points), ranks_(ranks), triangles_(triangles), offsets_(points.rows() + 1, 0),
          locked_(points.rows(), false), gone_(triangles.size(), false)
    {
        for (const Triangle& t : triangles)
            for (int v : t)
                ++offsets_[v + 1];
        for (std::size_t v = 1; v < offsets_.size(); ++v)
            offsets_[v] += offsets_[v - 1];
        around_.resize(offsets_.back());
        std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
        for (std::size_t t = 0; t < triangles.size(); ++t)
            for (int v : triangles[t])
                around_[next[v]++] = static_cast<int>(t);
    }

    /// The removed vertices, and in `triangles` what is left.
    std::vector<int> run(const std::vector<bool>& removable, int most, std::vector<Triangle>& triangles)
    {
        std::vector<std::pair<double, int>> order;
        for (int v = 0; v < points_.rows(); ++v)
            if (removable[v] && offsets_[v + 1] - offsets_[v] > 1)
                order.emplace_back(shortest_edge(v), v);
        double shortest = 0.0;
        for (const auto& [length, v] : order)
            if (length > 0 && (length < shortest || !(shortest > 0)))
                shortest = length;
        for (auto& [length, v] : order)
            length = length > 0 ? std::round(0.5 * steps_per_octave * std::log2(length / shortest)) : -1.0;
        std::ranges::sort(order, {},
                          [&](const auto& each) { return std::pair(each.first, ranks_[each.second]); });
        std::vector<int> removed;
        for (const auto& [step, v] : order) {
            if (static_cast<int>(removed.size()) == most)
                break;
            if (!locked_[v] && remove(v))
                removed.push_back(v);
        }
        triangles.clear();
        for (std::size_t t = 0; t < triangles_.size(); ++t)
            if (!gone_[t])
                triangles.push_back(triangles_[t]);
        triangles.insert(triangles.end(), filling_.begin(), filling_.end());
        std::ranges::sort(removed);
        return removed;
    }

private:
    Vector3 point(int v) const { return points_.row(v).transpose(); }
    Vector3 area(int a, int b, int c) const { return (point(b) - point(a)).cross(point(c) - point(a)); }
    double shape(int a, int b, int c) const
    {
        const double longest =
            std::max({(point(b) - point(a)).squaredNorm(), (point(c) - point(b)).squaredNorm(),
                      (point(a) - point(c)).squaredNorm()});
        return longest > 0 ? area(a, b, c).norm() / longest : 0.0;
    }
    /// Squared.
    double shortest_edge(int v) const
    {
        double shortest = -1.0;
        for (int k = offsets_[v]; k < offsets_[v + 1]; ++k)
            for (int other : triangles_[around_[k]])
                if (const double length = (point(other) - point(v)).squaredNorm();
                    other != v && (shortest < 0 || length < shortest))
                    shortest = length;
        return shortest;
    }

    /// The vertices around v in order, if the faces around it are a disc or half a disc.
    std::optional<std::vector<int>> ring(int v) const
    {
        std::vector<std::pair<int, int>> sides;
        for (int k = offsets_[v]; k < offsets_[v + 1]; ++k) {
            const Triangle& t = triangles_[around_[k]];
            if (has_corner_twice(t))
                return std::nullopt;
            const int at = t[0] == v ? 0 : t[1] == v ? 1 : 2;
            sides.emplace_back(t[(at + 1) % 3], t[(at + 2) % 3]);
        }
        const auto following = [&](int from) {
            return std::ranges::find(sides, from, &std::pair<int, int>::first);
        };
        int first = std::ranges::min(sides, {}, [&](const auto& side) { return ranks_[side.first]; }).first;
        for (const auto& [from, to] : sides)
            if (std::ranges::find(sides, from, &std::pair<int, int>::second) == sides.end())
                first = from; // where half a disc begins
        std::vector<int> vertices{first};
        for (std::size_t k = 0; k < sides.size(); ++k) {
            const auto side = following(vertices.back());
            if (side == sides.end() ||
                std::ranges::count(sides, side->first, &std::pair<int, int>::first) != 1)
                return std::nullopt;
            if (k + 1 == sides.size() && side->second == first)
                return vertices; // a disc
            if (std::ranges::find(vertices, side->second) != vertices.end())
                return std::nullopt;
            vertices.push_back(side->second);
        }
        return vertices;
    }

    bool are_joined(int a, int b) const
    {
        if (joints_.contains(joint(a, b)))
            return true;
        for (int k = offsets_[a]; k < offsets_[a + 1]; ++k)
            if (std::ranges::find(triangles_[around_[k]], b) != triangles_[around_[k]].end())
                return true;
        return false;
    }
    static std::int64_t joint(int a, int b)
    {
        return (static_cast<std::int64_t>(std::min(a, b)) << 32) | std::max(a, b);
    }

    bool remove(int v)
    {
        const std::optional<std::vector<int>> found = ring(v);
        if (!found || found->size() < 3)
            return false;
        const std::vector<int>& around = *found;
        const int count = static_cast<int>(around.size());
        Vector3 normal = Vector3::Zero();
        double worst = 1.0;
        for (int k = offsets_[v]; k < offsets_[v + 1]; ++k) {
            const auto [a, b, c] = triangles_[around_[k]];
            normal += area(a, b, c);
            worst = std::min(worst, shape(a, b, c));
        }
        const bool closed = offsets_[v + 1] - offsets_[v] == count;
        if (!closed && are_joined(around.front(), around.back()))
            return false;
        double best = std::min(least_shape, 0.5 * worst);
        int tip = -1;
        for (int r = 0; r < count; ++r)
            if (const double fan = fan_shape(around, r, normal); fan > (1 + alike) * best) {
                best = fan;
                tip = r;
            }
        if (tip < 0)
            return false;
        for (int k = 1; k + 1 < count; ++k) {
            const int a = around[(tip + k) % count], b = around[(tip + k + 1) % count];
            filling_.push_back({around[tip], a, b});
            joints_.insert(joint(around[tip], a));
            joints_.insert(joint(around[tip], b));
            joints_.insert(joint(a, b));
        }
        for (int k = offsets_[v]; k < offsets_[v + 1]; ++k)
            gone_[around_[k]] = true;
        locked_[v] = true;
        for (int other : around)
            locked_[other] = true;
        return true;
    }

    /// The worst shape of the triangles of a fan; -1 if it folds or has an edge that is there already.
    double fan_shape(const std::vector<int>& around, int tip, const Vector3& normal) const
    {
        const int count = static_cast<int>(around.size());
        double worst = 1.0;
        for (int k = 1; k + 1 < count; ++k) {
            const int a = around[(tip + k) % count], b = around[(tip + k + 1) % count];
            const Vector3 own = area(around[tip], a, b);
            if (!(own.dot(normal) > least_cosine * own.norm() * normal.norm()))
                return -1.0;
            if (k > 1 && are_joined(around[tip], a))
                return -1.0;
            worst = std::min(worst, shape(around[tip], a, b));
        }
        return worst;
    }

    const Points& points_;
    const std::vector<int>& ranks_;
    const std::vector<Triangle>& triangles_;
    std::vector<int> offsets_, around_; ///< the triangles at each vertex
    std::vector<bool> locked_, gone_;
    std::vector<Triangle> filling_;
    std::unordered_set<std::int64_t> joints_; ///< edges that come into being
};

} // namespace

ProgressiveLevels progressive_levels(const SurfaceMesh& mesh, std::vector<bool> removable, int most,
                                     int enough, const Progress& progress)
{
    ProgressiveLevels found;
    std::vector<bool> in_face(mesh.vertex_count(), false);
    for (const Triangle& t : mesh.triangles())
        if (!has_corner_twice(t)) {
            found.coarsest.push_back(t);
            for (int v : t)
                in_face[v] = true;
        }
    for (const Triangle& t : mesh.triangles())
        if (has_corner_twice(t) && !(in_face[t[0]] && in_face[t[1]] && in_face[t[2]])) {
            found.coarsest.push_back(t); // it alone joins a vertex to its part
            for (int v : t)
                removable[v] = false;
        }
    const auto there = static_cast<int>(std::ranges::count(removable, true));
    int left = there;
    const std::vector<int> order = order_by_place(mesh);
    std::vector<int> ranks(order.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        ranks[order[k]] = static_cast<int>(k);
    while (static_cast<int>(found.levels.size()) < most && left > enough) {
        progress.tick(0.5 * (there - left) / there, "coarsening");
        ProgressiveLevel level;
        std::vector<Triangle> coarser;
        level.inserted =
            Coarsening(mesh.points(), ranks, found.coarsest).run(removable, left - enough, coarser);
        if (level.inserted.empty())
            break;
        for (int v : level.inserted)
            removable[v] = false;
        left -= static_cast<int>(level.inserted.size());
        level.triangles = std::exchange(found.coarsest, std::move(coarser));
        found.levels.push_back(std::move(level));
    }
    std::ranges::reverse(found.levels);
    return found;
}

} // namespace sinew
