// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/harmonic/lattice.h"

#include "native/core/memory.h"
#include "native/mesh/trees/triangle_tree.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace sinew {

namespace {

using Node = HarmonicLattice::Node;

constexpr double about = 1e-9;   ///< a node lies on a crossing if it is at most so many steps away
constexpr double grazing = 1e-9; ///< a line passes too close to an edge if a hat value is below this

/// Twice the area of the triangle (a, b, (x, y)) in the plane of the axes u and v.
double area(const Vector3& a, const Vector3& b, int u, int v, double x, double y)
{
    return (b[u] - a[u]) * (y - a[v]) - (b[v] - a[v]) * (x - a[u]);
}

/// The hat values of the closest point of a triangle: C. Ericson, "Real-Time Collision Detection", 5.1.5.
Vector3 closest_hats(const Vector3& at, const Vector3& a, const Vector3& b, const Vector3& c)
{
    const Vector3 ab = b - a, ac = c - a, ap = at - a, bp = at - b, cp = at - c;
    const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp),
                 d6 = ac.dot(cp);
    if (d1 <= 0.0 && d2 <= 0.0)
        return {1.0, 0.0, 0.0};
    if (d3 >= 0.0 && d4 <= d3)
        return {0.0, 1.0, 0.0};
    if (d6 >= 0.0 && d5 <= d6)
        return {0.0, 0.0, 1.0};
    const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
        const double t = d1 / (d1 - d3);
        return {1.0 - t, t, 0.0};
    }
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
        const double t = d2 / (d2 - d6);
        return {1.0 - t, 0.0, t};
    }
    if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
        const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return {0.0, 1.0 - t, t};
    }
    return Vector3(va, vb, vc) / (va + vb + vc);
}

} // namespace

HarmonicLattice::HarmonicLattice(const Cage& cage, int cells) : triangles_(cage.triangles())
{
    const Points& points = cage.rest().points();
    const Vector3 low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
    step_ = (high - low).maxCoeff() / cells;
    require_memory(bytes(cage, cells), "the lattice in the cage");
    for (int axis = 0; axis < 3; ++axis)
        size_[axis] = static_cast<int>(std::ceil((high[axis] - low[axis]) / step_)) + 3;
    // If a line passes through a vertex, rounding may count a triangle too many or too few. Then the lattice
    // is moved a little.
    for (double shift = 0.0;; shift += 0.01) {
        origin_ = low - step_ * Vector3(.37 + shift, .41 + shift, .43 + shift);
        points_.clear();
        for (Eigen::Index v = 0; v < points.rows(); ++v)
            points_.push_back(coordinates(points.row(v).transpose()));
        if (cross() || shift > 0.4)
            break;
    }
    bin();
}

std::int64_t HarmonicLattice::bytes(const Cage& cage, int cells)
{
    const Points& points = cage.rest().points();
    const Vector3 sides = (points.colwise().maxCoeff() - points.colwise().minCoeff()).transpose();
    const Vector3 nodes = sides / sides.maxCoeff() * cells + Vector3::Constant(3.0);
    return static_cast<std::int64_t>(nodes.prod() * (2 * sizeof(int) + 1));
}

/// Finds all crossings and the winding of the nodes.
/// \return whether every line leaves the cage as often as it enters it
bool HarmonicLattice::cross()
{
    bool closed = true;
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        std::vector<std::pair<int, Crossing>> found;
        for (int t = 0; t < static_cast<int>(triangles_.size()); ++t) {
            const auto range = [&](int along) {
                const auto [least, most] =
                    std::minmax({corner(t, 0)[along], corner(t, 1)[along], corner(t, 2)[along]});
                return std::pair(static_cast<int>(std::ceil(least)), static_cast<int>(std::floor(most)));
            };
            const auto [u0, u1] = range(u);
            const auto [v0, v1] = range(v);
            for (int i = u0; i <= u1; ++i)
                for (int j = v0; j <= v1; ++j) {
                    // Both triangles at an edge compute the same number for it, so that a line near the edge
                    // crosses exactly one of them.
                    Vector3 hats;
                    int left = 0;
                    for (int k = 0; k < 3; ++k) {
                        const int from = (k + 1) % 3, to = (k + 2) % 3;
                        const bool swapped = triangles_[t][from] > triangles_[t][to];
                        const double a = swapped ? area(corner(t, to), corner(t, from), u, v, i, j)
                                                 : area(corner(t, from), corner(t, to), u, v, i, j);
                        left += (a > 0.0) != swapped;
                        hats[k] = std::abs(a);
                    }
                    if ((left != 0 && left != 3) || !(hats.sum() > 0.0))
                        continue;
                    hats /= hats.sum();
                    const double depth = hats[0] * corner(t, 0)[axis] + hats[1] * corner(t, 1)[axis] +
                                         hats[2] * corner(t, 2)[axis];
                    found.push_back({i * size_[v] + j, {depth, t, left == 3 ? -1 : 1, hats}});
                }
        }
        std::ranges::sort(found, {}, [](const auto& entry) {
            const auto& [line, crossing] = entry;
            return std::tuple(line, crossing.depth, crossing.triangle);
        });
        std::vector<int>& first = first_[axis];
        first.assign(static_cast<std::size_t>(size_[u]) * size_[v] + 1, 0);
        crossings_[axis].clear();
        std::vector<int> balance(first.size(), 0);
        for (const auto& [line, crossing] : found) {
            ++first[line + 1];
            balance[line] += crossing.turn;
            crossings_[axis].push_back(crossing);
        }
        for (std::size_t line = 1; line < first.size(); ++line)
            first[line] += first[line - 1];
        closed = closed && std::ranges::all_of(balance, [](int turns) { return turns == 0; });
    }
    winding_.assign(static_cast<std::size_t>(size_[0]) * size_[1] * size_[2], 0);
    for (int j = 0; j < size_[1]; ++j)
        for (int k = 0; k < size_[2]; ++k) {
            const int line = j * size_[2] + k;
            int turns = 0, c = first_[0][line];
            for (int i = 0; i < size_[0]; ++i) {
                for (; c < first_[0][line + 1] && crossings_[0][c].depth <= i; ++c)
                    turns += crossings_[0][c].turn;
                winding_[index({i, j, k})] = static_cast<std::int8_t>(std::clamp(turns, -100, 100));
            }
        }
    return closed;
}

/// Lists the triangles of each cube: those that meet the sphere around it, and some more at its corners.
void HarmonicLattice::bin()
{
    std::vector<std::pair<int, int>> found;
    for (int t = 0; t < static_cast<int>(triangles_.size()); ++t) {
        const Vector3 &a = corner(t, 0), &b = corner(t, 1), &c = corner(t, 2);
        const Vector3 normal = (b - a).cross(c - a);
        Node low, high;
        for (int axis = 0; axis < 3; ++axis) {
            const auto [least, most] = std::minmax({a[axis], b[axis], c[axis]});
            low[axis] = static_cast<int>(std::floor(least - about));
            high[axis] = static_cast<int>(std::floor(most + about));
        }
        const double reach = (0.5 + about) * normal.lpNorm<1>();
        for (int i = low[0]; i <= high[0]; ++i)
            for (int j = low[1]; j <= high[1]; ++j)
                for (int k = low[2]; k <= high[2]; ++k) {
                    const Vector3 middle(i + .5, j + .5, k + .5);
                    if (!(std::abs(normal.dot(middle - a)) <= reach))
                        continue;
                    const Vector3 hats = closest_hats(middle, a, b, c);
                    if ((hats[0] * a + hats[1] * b + hats[2] * c - middle).squaredNorm() <= 0.75 + about)
                        found.emplace_back(static_cast<int>(index({i, j, k})), t);
                }
    }
    std::ranges::sort(found);
    first_in_cell_.assign(winding_.size() + 1, 0);
    for (const auto& [cell, triangle] : found) {
        ++first_in_cell_[cell + 1];
        in_cell_.push_back(triangle);
    }
    for (std::size_t cell = 1; cell < first_in_cell_.size(); ++cell)
        first_in_cell_[cell] += first_in_cell_[cell - 1];
}

const HarmonicLattice::Crossing* HarmonicLattice::next(const Node& node, int axis, int sign,
                                                       double reach) const
{
    const int u = (axis + 1) % 3, v = (axis + 2) % 3, line = node[u] * size_[v] + node[v];
    const Crossing* const begin = crossings_[axis].data() + first_[axis][line];
    const Crossing* const end = crossings_[axis].data() + first_[axis][line + 1];
    const auto distance = [&](const Crossing& c) { return sign * (c.depth - node[axis]); };
    const Crossing* best = nullptr;
    for (const Crossing* c = begin; c != end; ++c) {
        const double d = distance(*c);
        if (d < -about || d > reach)
            continue;
        // Where faces touch, this is the one at which the inside ends.
        if (!best || d < distance(*best) - about ||
            (d < distance(*best) + about && c->turn == -sign && best->turn != -sign))
            best = c;
    }
    return best;
}

bool HarmonicLattice::is_cell(const Node& cell) const
{
    bool in = true;
    for (int axis = 0; axis < 3; ++axis)
        in = in && cell[axis] >= 0 && cell[axis] + 1 < size_[axis];
    return in;
}

bool HarmonicLattice::cube(const Vector3& at, int width, Node& lowest) const
{
    for (int axis = 0; axis < 3; ++axis) {
        if (!(at[axis] >= 0.0 && at[axis] < size_[axis] - 1))
            return false;
        lowest[axis] = static_cast<int>(at[axis]) / width * width;
    }
    return true;
}

std::span<const int> HarmonicLattice::touching(const Node& cell) const
{
    const std::size_t at = index(cell);
    return {in_cell_.data() + first_in_cell_[at],
            static_cast<std::size_t>(first_in_cell_[at + 1] - first_in_cell_[at])};
}

bool HarmonicLattice::is_full(const Node& lowest, int width) const
{
    if (!inside(lowest))
        return false;
    for (int i = 0; i < width; ++i)
        for (int j = 0; j < width; ++j)
            for (int k = 0; k < width; ++k) {
                const Node cell{lowest[0] + i, lowest[1] + j, lowest[2] + k};
                if (!is_cell(cell) || !touching(cell).empty())
                    return false;
            }
    return true;
}

bool HarmonicLattice::holds(const Vector3& at) const
{
    Node cell;
    if (!cube(at, 1, cell))
        return false;
    const std::span<const int> triangles = touching(cell);
    // The winding differs from that of a corner of the cube by the triangles that cross the way to it. A
    // corner is used only if that way does not pass close to an edge.
    for (int c = 0; c < 8; ++c) {
        const Node node{cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2)};
        const Vector3 end(node[0], node[1], node[2]);
        int winding = static_cast<int>(winding_[index(node)]);
        bool clear = true;
        for (std::size_t k = 0; k < triangles.size() && clear; ++k) {
            const Vector3 &p = corner(triangles[k], 0), &q = corner(triangles[k], 1),
                          &r = corner(triangles[k], 2);
            const Vector3 normal = (q - p).cross(r - p);
            const double height = normal.dot(at - p), above = normal.dot(end - p);
            const double least = grazing * normal.norm();
            if ((height > least && above > least) || (height < -least && above < -least))
                continue;
            const Vector3 along = end - at;
            const Vector3 s(along.dot((q - at).cross(r - at)), along.dot((r - at).cross(p - at)),
                            along.dot((p - at).cross(q - at)));
            const bool passes_by = s.maxCoeff() > least && s.minCoeff() < -least;
            if (passes_by)
                continue;
            clear = s.cwiseAbs().minCoeff() > least && std::abs(height) > least && std::abs(above) > least;
            winding += height > 0.0 ? -1 : 1; // -1 where the way to the corner enters the cage
        }
        if (clear)
            return winding == 1;
    }
    return std::abs(winding_number(points_, triangles_, at) - 1.0) < 0.5;
}

HarmonicLattice::Hit HarmonicLattice::closest(const Vector3& at, int width) const
{
    Hit best;
    const int reach = 2 * width;
    best.distance = reach;
    Node own;
    if (!cube(at, 1, own))
        return best;
    bool facing = false;
    const auto look = [&](const Node& cell) {
        for (int t : touching(cell)) {
            const Vector3 hats = closest_hats(at, corner(t, 0), corner(t, 1), corner(t, 2));
            const Hit hit{0.0, t, hats, {}};
            const Vector3 away = at - on(hit);
            const double distance = away.norm();
            // Where faces touch, this is the one that the point is behind.
            const bool faces = normal(t).dot(away) <= 0.0;
            if (distance < best.distance - about || (distance < best.distance + about && faces && !facing)) {
                best = hit;
                best.distance = distance;
                facing = faces;
            }
        }
    };
    look(own);
    for (int i = -reach; i <= reach; ++i)
        for (int j = -reach; j <= reach; ++j)
            for (int k = -reach; k <= reach; ++k) {
                const Node cell{own[0] + i, own[1] + j, own[2] + k};
                double square = 0.0;
                for (int axis = 0; axis < 3; ++axis)
                    square += std::pow(std::max({cell[axis] - at[axis], at[axis] - cell[axis] - 1, 0.0}), 2);
                if (is_cell(cell) && square <= best.distance * best.distance)
                    look(cell);
            }
    return best;
}

Vector3 HarmonicLattice::normal(int triangle) const
{
    return (corner(triangle, 1) - corner(triangle, 0))
        .cross(corner(triangle, 2) - corner(triangle, 0))
        .normalized();
}

HarmonicLattice::Hit HarmonicLattice::march(const Vector3& at, const Vector3& along, int width) const
{
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Hit hit;
    Node cell;
    if (!cube(at, 1, cell))
        return hit;
    for (double from = 0.0; is_cell(cell);) {
        const Node lowest{cell[0] / width * width, cell[1] / width * width, cell[2] / width * width};
        if (is_full(lowest, width)) {
            hit.distance = from;
            hit.full = lowest;
            return hit;
        }
        int axis = 0;
        double to = infinity;
        for (int k = 0; k < 3; ++k) {
            const double wall = ((along[k] > 0.0 ? cell[k] + 1 : cell[k]) - at[k]) / along[k];
            if (along[k] != 0.0 && wall < to) {
                to = wall;
                axis = k;
            }
        }
        hit.distance = infinity;
        for (int t : touching(cell)) {
            const Vector3 p = corner(t, 0) - at, q = corner(t, 1) - at, r = corner(t, 2) - at;
            const Vector3 normal = (q - p).cross(r - p);
            const double speed = normal.dot(along);
            if (!(speed > 0.0)) // the ray does not leave through this triangle
                continue;
            const Vector3 s(along.dot(q.cross(r)), along.dot(r.cross(p)), along.dot(p.cross(q)));
            const double distance = normal.dot(p) / speed;
            if (s.minCoeff() < -grazing * s.cwiseAbs().sum() || distance < 0.0 || distance > to + grazing ||
                distance >= hit.distance)
                continue;
            const Vector3 hats = s.cwiseMax(0.0);
            hit = {distance, t, hats / hats.sum(), {}};
        }
        if (hit.triangle >= 0)
            return hit;
        from = std::max(to, 0.0);
        cell[axis] += along[axis] > 0.0 ? 1 : -1;
    }
    return hit;
}

} // namespace sinew
