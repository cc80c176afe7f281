// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/tufted_cover.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <numbers>
#include <span>
#include <tuple>

namespace sinew {

namespace {

constexpr double least_slack = 1e-5; ///< of a triangle, as a share of the mean length
constexpr double rounding = 1e-12; ///< of the sine that decides about a side
constexpr int most_turns = 100; ///< per side, in case that rounding turns some sides for ever

// Side 3 t + k of the cover runs from corner k of triangle t to the next one.
int next(int side) { return side % 3 == 2 ? side - 2 : side + 1; }
int last(int side) { return side % 3 == 0 ? side + 2 : side - 1; }

/// A side of a triangle of the mesh, and the angle at which the triangle stands off its edge.
struct Leaf
{
    int low, high; ///< the vertices of the edge
    double angle;
    int triangle, corner;
    bool rises; ///< whether it runs from low to high, so that its front looks to growing angles

    /// The side of its copy that looks to growing angles, or to falling ones. Copy 2 t is the front of
    /// triangle t, copy 2 t + 1 its back, with the second and third corner exchanged.
    int side(bool growing) const
    {
        return rises == growing ? 6 * triangle + corner : 6 * triangle + 3 + 2 - corner;
    }
};

class Cover
{
public:
    explicit Cover(const SurfaceMesh& mesh)
    {
        const auto& triangles = mesh.triangles();
        const int count = static_cast<int>(triangles.size());
        vertex_.resize(6 * triangles.size());
        length_.resize(vertex_.size());
        twin_.resize(vertex_.size());
        for (int t = 0; t < count; ++t)
            for (int k = 0; k < 3; ++k) {
                vertex_[6 * t + k] = triangles[t][k];
                vertex_[6 * t + 3 + k] = triangles[t][(3 - k) % 3];
                const double length =
                    (mesh.point(triangles[t][(k + 1) % 3]) - mesh.point(triangles[t][k])).norm();
                length_[6 * t + k] = length_[6 * t + 3 + 2 - k] = length;
            }
        glue(mesh);
        lengthen();
    }

    /// \return how many sides were turned.
    std::int64_t make_delaunay()
    {
        std::deque<int> open;
        std::vector<char> waits(twin_.size(), 1);
        for (int side = 0; side < static_cast<int>(twin_.size()); ++side)
            open.push_back(side);
        const std::int64_t most = std::int64_t{most_turns} * std::ssize(twin_);
        std::int64_t flips = 0;
        while (!open.empty() && flips < most) {
            const int side = open.front();
            open.pop_front();
            waits[side] = 0;
            if (is_delaunay(side))
                continue;
            flip(side);
            ++flips;
            for (int turned : {side, twin_[side]})
                for (int beside : {next(turned), last(turned)})
                    if (!waits[beside]) {
                        waits[beside] = 1;
                        open.push_back(beside);
                    }
        }
        return flips;
    }

    IntrinsicTriangles triangles() const
    {
        IntrinsicTriangles found;
        for (std::size_t side = 0; side < vertex_.size(); side += 3) {
            found.triangles.push_back({vertex_[side], vertex_[side + 1], vertex_[side + 2]});
            found.lengths.push_back({length_[side], length_[side + 1], length_[side + 2]});
        }
        return found;
    }

    bool was_lengthened() const { return was_lengthened_; }

private:
    void glue(const SurfaceMesh& mesh)
    {
        std::vector<Leaf> leaves;
        const auto& triangles = mesh.triangles();
        for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
            for (int k = 0; k < 3; ++k) {
                const int from = triangles[t][k], to = triangles[t][(k + 1) % 3];
                leaves.push_back({std::min(from, to), std::max(from, to), 0.0, t, k, from <= to});
            }
        const auto by_edge = [](const Leaf& a, const Leaf& b) {
            return std::tie(a.low, a.high) < std::tie(b.low, b.high);
        };
        std::ranges::stable_sort(leaves, by_edge);
        for (auto begin = leaves.begin(), end = begin; begin != leaves.end(); begin = end) {
            end =
                std::find_if(begin, leaves.end(), [&](const Leaf& other) { return by_edge(*begin, other); });
            if (end - begin > 2)
                sort_around(mesh, {begin, end});
            for (auto leaf = begin; leaf != end; ++leaf) {
                const Leaf& after = leaf + 1 == end ? *begin : leaf[1];
                const int a = leaf->side(true), b = after.side(false);
                twin_[a] = b;
                twin_[b] = a;
            }
        }
    }

    /// Triangles at the same angle stay in their order.
    static void sort_around(const SurfaceMesh& mesh, std::span<Leaf> leaves)
    {
        const auto off = [&](const Leaf& leaf) -> Vector3 {
            return mesh.point(mesh.triangles()[leaf.triangle][(leaf.corner + 2) % 3]) - mesh.point(leaf.low);
        };
        const Vector3 axis = (mesh.point(leaves[0].high) - mesh.point(leaves[0].low)).normalized();
        const Vector3 x = off(leaves[0]) - axis.dot(off(leaves[0])) * axis;
        const Vector3 y = axis.cross(x);
        for (Leaf& leaf : leaves.subspan(1)) {
            const double angle = std::atan2(y.dot(off(leaf)), x.dot(off(leaf)));
            leaf.angle = angle < 0.0 ? angle + 2 * std::numbers::pi : angle;
        }
        std::ranges::stable_sort(leaves, {}, &Leaf::angle);
    }

    void lengthen()
    {
        double mean = 0.0, missing = 0.0;
        for (double length : length_)
            mean += length / static_cast<double>(length_.size());
        for (std::size_t t = 0; t < length_.size(); t += 3) {
            const std::array l{length_[t], length_[t + 1], length_[t + 2]};
            for (int k = 0; k < 3; ++k)
                missing = std::max(missing, least_slack * mean - (l[(k + 1) % 3] + l[(k + 2) % 3] - l[k]));
        }
        was_lengthened_ = missing > 0.0;
        if (was_lengthened_)
            for (double& length : length_)
                length += missing;
    }

    /// Of the angle opposite to a side: cosine and sine, both times the lengths beside it.
    std::array<double, 2> opposite(int side) const
    {
        const double a = length_[side], b = length_[next(side)], c = length_[last(side)];
        const double square = (a + b + c) * (b + c - a) * (a + c - b) * (a + b - c); // (4 area)^2
        return {0.5 * (b * b + c * c - a * a), 0.5 * std::sqrt(std::max(square, 0.0))};
    }

    /// The opposite angles have the sum pi or less where the sine of that sum is not negative.
    bool is_delaunay(int side) const
    {
        const int twin = twin_[side];
        if (twin / 3 == side / 3)
            return true; // both are angles of one triangle
        const auto [cos_one, sin_one] = opposite(side);
        const auto [cos_other, sin_other] = opposite(twin);
        const double scale = std::hypot(cos_one, sin_one) * std::hypot(cos_other, sin_other);
        return cos_one * sin_other + cos_other * sin_one >= -rounding * scale;
    }

    /// Turns the side between triangles (a, b, c) and (b, a, d): they become (d, c, a) and (c, d, b).
    void flip(int side)
    {
        const int twin = twin_[side];
        // With a at the origin and b on the first axis, c is at (along_c, up_c), and d on the other side.
        const double ab = length_[side];
        const double along_c = opposite(next(side))[0] / ab, up_c = opposite(side)[1] / ab;
        const double along_d = opposite(last(twin))[0] / ab, up_d = opposite(twin)[1] / ab;
        const double cd = std::hypot(along_c - along_d, up_c + up_d);

        struct Side
        {
            int place, from, twin;
            double length;
        };
        const auto read = [&](int old, int place) {
            return Side{place, vertex_[old], twin_[old], length_[old]};
        };
        const int bc = next(side), ca = last(side), ad = next(twin), db = last(twin);
        const std::array moved{read(ca, next(side)), read(ad, last(side)), read(db, next(twin)),
                               read(bc, last(twin))};
        const std::array<int, 4> old{ca, ad, db, bc};
        vertex_[side] = moved[2].from; // d
        vertex_[twin] = moved[0].from; // c
        length_[side] = length_[twin] = cd;
        for (const Side& each : moved) {
            vertex_[each.place] = each.from;
            length_[each.place] = each.length;
            // Its twin may be another one of the four.
            const auto found = std::ranges::find(old, each.twin) - old.begin();
            const int other = found < 4 ? moved[found].place : each.twin;
            twin_[each.place] = other;
            twin_[other] = each.place;
        }
    }

    std::vector<int> vertex_; ///< where each side begins
    std::vector<double> length_;
    std::vector<int> twin_; ///< the side that is glued to it
    bool was_lengthened_ = false;
};

} // namespace

std::optional<IntrinsicTriangles> delaunay_cover(const SurfaceMesh& mesh)
{
    Cover cover(mesh);
    const bool changed = cover.make_delaunay() > 0 || cover.was_lengthened();
    return changed ? std::optional(cover.triangles()) : std::nullopt;
}

} // namespace sinew
