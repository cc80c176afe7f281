// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/triangulation.h"

#include "native/core/dense.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace sinew {

namespace {

using Vector2 = Eigen::Vector2d;

double cross(const Vector2& a, const Vector2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Corner positions in the plane of the polygon's area vector, counter-clockwise.
std::vector<Vector2> flatten(const Points& points, std::span<const int> polygon)
{
    const Vector3 origin = points.row(polygon[0]).transpose();
    const auto at = [&](std::size_t k) -> Vector3 {
        return points.row(polygon[k % polygon.size()]).transpose() - origin;
    };
    Vector3 normal = Vector3::Zero();
    for (std::size_t k = 0; k < polygon.size(); ++k)
        normal += at(k).cross(at(k + 1));
    const Eigen::Quaterniond turn =
        normal.squaredNorm() > 0 ? smallest_turn(normal, Vector3::UnitZ()) : Eigen::Quaterniond::Identity();
    std::vector<Vector2> flat(polygon.size());
    for (std::size_t k = 0; k < polygon.size(); ++k)
        flat[k] = (turn * at(k)).head<2>();
    return flat;
}

/// The shape of the triangle at a corner: 1 if it is equilateral, 0 if it has no area, negative if the corner
/// is reflex.
double quality(const Vector2& a, const Vector2& b, const Vector2& c)
{
    const double lengths = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
    return lengths > 0 ? 2 * std::sqrt(3.0) * cross(b - a, c - a) / lengths : 0.0;
}

bool inside(const Vector2& p, const Vector2& a, const Vector2& b, const Vector2& c)
{
    return cross(b - a, p - a) >= 0 && cross(c - b, p - b) >= 0 && cross(a - c, p - c) >= 0;
}

/// Whether the direction d lies between the directions `first` and `last`, counter-clockwise, or along one.
bool between(const Vector2& d, const Vector2& first, const Vector2& last)
{
    const bool after = cross(first, d) >= 0, before = cross(d, last) >= 0;
    return cross(first, last) > 0 ? after && before : after || before;
}

class EarClipper
{
public:
    EarClipper(std::span<const int> polygon, std::vector<Vector2> flat)
        : polygon_(polygon), flat_(std::move(flat)), previous_(flat_.size()), next_(flat_.size()),
          score_(flat_.size())
    {
        const int k = static_cast<int>(flat_.size());
        for (int i = 0; i < k; ++i) {
            previous_[i] = (i + k - 1) % k;
            next_[i] = (i + 1) % k;
        }
        for (int i = 0; i < k; ++i)
            score_[i] = score(i);
    }

    void run(std::vector<Triangle>& triangles)
    {
        for (std::size_t left = flat_.size(); left > 2; --left) {
            const int ear = best_ear();
            const int a = previous_[ear];
            const int b = next_[ear];
            triangles.push_back({polygon_[a], polygon_[ear], polygon_[b]});
            next_[a] = b;
            previous_[b] = a;
            score_[ear] = cut_off;
            if (left > 3)
                for (const int i : {previous_[a], a, b, next_[b]})
                    score_[i] = score(i);
        }
    }

private:
    static constexpr double no_ear = -2; ///< such scores, and lower ones
    static constexpr double cut_off = -std::numeric_limits<double>::infinity();

    /// The corner to cut next. Scores are kept, and a corner that was no ear is one as soon as what was in
    /// its triangle has been cut off.
    int best_ear()
    {
        auto best = std::ranges::max_element(score_);
        if (*best <= no_ear) {
            for (std::size_t i = 0; i < score_.size(); ++i)
                if (score_[i] != cut_off)
                    score_[i] = score(static_cast<int>(i));
            best = std::ranges::max_element(score_);
        }
        return static_cast<int>(best - score_.begin());
    }

    /// The quality of the ear at corner i. A corner that is no ear is cut only when no ear is left.
    double score(int i) const
    {
        const int a = previous_[i];
        const int b = next_[i];
        const double q = quality(flat_[a], flat_[i], flat_[b]);
        if (q <= 0)
            return no_ear - 1 + q;
        if (!opens_to(a, b) || !opens_to(b, a))
            return no_ear;
        for (int p = next_[b]; p != a; p = next_[p])
            if (inside(flat_[p], flat_[a], flat_[i], flat_[b]) && flat_[p] != flat_[a] &&
                flat_[p] != flat_[i] && flat_[p] != flat_[b])
                return no_ear;
        return q;
    }

    /// Whether the polygon is on the way from one corner to another, close to the first. Where a polygon
    /// has a slit, two corners are at the same place, and each opens to a side of its own.
    bool opens_to(int corner, int other) const
    {
        const Vector2& from = flat_[corner];
        return between(flat_[other] - from, flat_[next_[corner]] - from, flat_[previous_[corner]] - from);
    }

    std::span<const int> polygon_;
    std::vector<Vector2> flat_;
    std::vector<int> previous_, next_;
    std::vector<double> score_;
};

/// Cuts along the diagonal whose worse triangle is the better one; with triangles that are equal but for what
/// rounding of the points can do, along the one from corner 0.
void cut_quad(const Points& points, std::span<const int> q, std::vector<Triangle>& triangles)
{
    const std::vector<Vector2> p = flatten(points, q);
    const double first = std::min(quality(p[0], p[1], p[2]), quality(p[0], p[2], p[3]));
    const double second = std::min(quality(p[0], p[1], p[3]), quality(p[1], p[2], p[3]));
    constexpr double equal = 1e-4; // as a share
    if (first >= second - equal * std::abs(second)) {
        triangles.push_back({q[0], q[1], q[2]});
        triangles.push_back({q[0], q[2], q[3]});
    } else {
        triangles.push_back({q[0], q[1], q[3]});
        triangles.push_back({q[1], q[2], q[3]});
    }
}

} // namespace

void triangulate(const Points& points, std::span<const int> polygon, std::vector<Triangle>& triangles)
{
    if (polygon.size() == 3)
        triangles.push_back({polygon[0], polygon[1], polygon[2]});
    else if (polygon.size() == 4)
        cut_quad(points, polygon, triangles);
    else
        EarClipper(polygon, flatten(points, polygon)).run(triangles);
}

} // namespace sinew
