// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/enclosure/progressive_hull.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <tuple>
#include <utility>

namespace sinew {

namespace {

constexpr double closeness = 1e-3; // weight of the distance to the edge's middle, where the planes have 1
constexpr double least_cosine = 0.2; // between the normals before and after a collapse: 78 degrees
constexpr double least_shape = 0.1; // of a triangle; an equilateral one has 1
constexpr double fold_cosine = -0.97; // between the normals of neighbours: 14 degrees from a fold
constexpr double farthest = 0.25; // how far from its edge a new vertex may be, as a share of the size

/// The points p with normal.p >= distance.
struct HalfSpace
{
    Vector3 normal;
    double distance;
};

/// Finds the minimum of (p - centre)' H (p - centre) over the points of origin + span that are in all half
/// spaces. The half spaces are added one by one: where one is violated, the new minimum lies on its plane, so
/// it is sought there, among the half spaces before it.
/// \return false where no point is in all half spaces.
template <int Dim>
bool minimum(const Matrix3& H, const Vector3& centre, std::span<const HalfSpace> spaces,
             const Vector3& origin, const Eigen::Matrix<double, 3, Dim>& span, double slack, Vector3& p)
{
    if constexpr (Dim == 0) {
        p = origin;
        return std::ranges::all_of(spaces,
                                   [&](const HalfSpace& h) { return h.normal.dot(p) >= h.distance - slack; });
    } else {
        const Eigen::Matrix<double, Dim, Dim> A = span.transpose() * H * span;
        p = origin + span * A.ldlt().solve(span.transpose() * (H * (centre - origin)));
        for (std::size_t i = 0; i < spaces.size(); ++i) {
            const HalfSpace& h = spaces[i];
            if (h.normal.dot(p) >= h.distance - slack)
                continue;
            const Eigen::Matrix<double, Dim, 1> along = span.transpose() * h.normal;
            if (along.squaredNorm() < 1e-8)
                return false;
            const Vector3 on =
                origin + span * (along * ((h.distance - h.normal.dot(origin)) / along.squaredNorm()));
            Eigen::Matrix<double, 3, Dim - 1> rest;
            if constexpr (Dim == 3) {
                rest.col(0) = h.normal.unitOrthogonal();
                rest.col(1) = h.normal.cross(rest.col(0));
            } else if constexpr (Dim == 2) {
                rest.col(0) = span * Eigen::Vector2d(-along[1], along[0]).normalized();
            }
            if (!minimum<Dim - 1>(H, centre, spaces.first(i), on, rest, slack, p))
                return false;
        }
        return true;
    }
}

Vector3 area_of(const Corners& t) { return 0.5 * (t[1] - t[0]).cross(t[2] - t[0]); }

/// The shape of a triangle: 1 if it is equilateral, 0 if it has no area.
double shape(const Corners& t)
{
    const double sides =
        (t[1] - t[0]).squaredNorm() + (t[2] - t[1]).squaredNorm() + (t[0] - t[2]).squaredNorm();
    return sides > 0.0 ? 4.0 * std::sqrt(3.0) * area_of(t).norm() / sides : 0.0;
}

bool contains(std::span<const int> list, int value) { return std::ranges::find(list, value) != list.end(); }

int shared_corners(const Triangle& a, const Triangle& b)
{
    return static_cast<int>(std::ranges::count_if(a, [&](int v) { return contains(b, v); }));
}

/// Whether two triangles at a common edge are nearly folded onto each other.
bool nearly_folded(const Corners& a, const Corners& b)
{
    const Vector3 m = area_of(a), n = area_of(b);
    return m.dot(n) < fold_cosine * m.norm() * n.norm();
}

bool collide(const Corners& a, const Triangle& a_indices, const Corners& b, const Triangle& b_indices)
{
    return triangles_meet(a, a_indices, b, b_indices) ||
           (shared_corners(a_indices, b_indices) == 2 && nearly_folded(a, b));
}

} // namespace

ProgressiveHull::ProgressiveHull(TriangleSoup surface, double size, int mirror_axis)
    : points_(std::move(surface.points)), faces_(std::move(surface.triangles)), alive_(faces_.size(), 1),
      around_(points_.size()), stamps_(points_.size(), 0), size_(size), mirror_axis_(mirror_axis),
      face_count_(static_cast<int>(faces_.size()))
{
    for (int f = 0; f < face_count_; ++f)
        for (int v : faces_[f])
            around_[v].push_back(f);
    renew_boxes();
}

std::vector<int> ProgressiveHull::ring(int vertex) const
{
    std::vector<int> ring;
    for (int f : around_[vertex])
        for (int v : faces_[f])
            if (v != vertex)
                ring.push_back(v);
    std::ranges::sort(ring);
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    return ring;
}

std::vector<int> ProgressiveHull::faces_around(int a, int b) const
{
    std::vector<int> faces = around_[a];
    for (int f : around_[b])
        if (!contains(around_[a], f))
            faces.push_back(f);
    return faces;
}

Vector3 ProgressiveHull::area(int face) const { return area_of(corners_of(points_, faces_[face])); }

void ProgressiveHull::renew_boxes()
{
    live_.clear();
    boxes_.resize(faces_.size());
    for (int f = 0; f < static_cast<int>(faces_.size()); ++f) {
        if (!alive_[f])
            continue;
        live_.push_back(f);
        boxes_[f].setEmpty();
        for (int v : faces_[f])
            boxes_[f].extend(points_[v]);
    }
}

/// Queues the edge (a, b) with the point that it would be collapsed to.
void ProgressiveHull::propose(int a, int b)
{
    const bool mirror = on_mirror(a) || on_mirror(b);
    const Vector3 middle = 0.5 * (points_[a] + points_[b]); // the origin of what follows, to round less
    Matrix3 H = Matrix3::Zero();
    Vector3 h = Vector3::Zero();
    double constant = 0.0, total = 0.0;
    std::vector<HalfSpace> spaces;
    for (int f : faces_around(a, b)) {
        const Vector3 normal = area(f);
        const double weight = normal.norm();
        if (weight < 1e-14 * size_ * size_)
            continue;
        const Vector3 n = normal / weight;
        const double d = n.dot(points_[faces_[f][0]] - middle);
        spaces.push_back({n, d});
        H += weight * n * n.transpose();
        h += weight * d * n;
        constant += weight * d * d;
        total += weight;
    }
    H += closeness * total * Matrix3::Identity();
    const Vector3 centre = H.ldlt().solve(h);
    const double slack = 1e-10 * size_;
    Vector3 p;
    if (mirror) {
        Vector3 origin = Vector3::Zero();
        origin[mirror_axis_] = -middle[mirror_axis_];
        Eigen::Matrix<double, 3, 2> span = Eigen::Matrix<double, 3, 2>::Zero();
        span((mirror_axis_ + 1) % 3, 0) = span((mirror_axis_ + 2) % 3, 1) = 1.0;
        if (!minimum<2>(H, centre, spaces, origin, span, slack, p))
            return;
    } else {
        if (mirror_axis_ >= 0) {
            const double apart = std::min(points_[a][mirror_axis_], points_[b][mirror_axis_]);
            spaces.push_back({Vector3::Unit(mirror_axis_), 0.5 * apart - middle[mirror_axis_]});
        }
        if (!minimum<3>(H, centre, spaces, Vector3::Zero(), Matrix3::Identity(), slack, p))
            return;
    }
    if (p.norm() > farthest * size_)
        return;
    const double cost = p.dot(H * p) - 2.0 * h.dot(p) + constant;
    Vector3 point = middle + p;
    if (mirror)
        point[mirror_axis_] = 0.0;
    queue_.push({cost, a, b, stamps_[a] + stamps_[b], point});
}

/// Whether no face of the fan meets another one of the fan, or a face of the surface that is not `replaced`.
bool ProgressiveHull::stays_embedded(const Fan& fan, const std::vector<int>& replaced)
{
    Box whole;
    for (const Corners& t : fan.corners)
        for (const Vector3& corner : t)
            whole.extend(corner);
    std::vector<int> close;
    for (int f : live_)
        if (alive_[f] && boxes_[f].intersects(whole) && !contains(replaced, f))
            close.push_back(f);
    for (std::size_t i = 0; i < fan.corners.size(); ++i) {
        const Corners& t = fan.corners[i];
        if (is_flat(t))
            return false;
        Box box;
        for (const Vector3& corner : t)
            box.extend(corner);
        for (int f : close)
            if (boxes_[f].intersects(box) &&
                collide(t, fan.indices[i], corners_of(points_, faces_[f]), faces_[f]))
                return false;
        for (std::size_t j = 0; j < i; ++j)
            if (collide(t, fan.indices[i], fan.corners[j], fan.indices[j]))
                return false;
    }
    return true;
}

/// An edge inside the half whose ends are both on the mirror would coincide with its mirror image, so there
/// must be none.
bool ProgressiveHull::keeps_mirror(const Fan& fan, int vertex, bool on) const
{
    if (mirror_axis_ < 0 || !on)
        return true;
    std::vector<int> neighbours;
    for (const Triangle& t : fan.indices)
        for (int v : t)
            if (v != vertex && on_mirror(v))
                neighbours.push_back(v);
    std::ranges::sort(neighbours);
    return std::ranges::adjacent_find(neighbours) == neighbours.end();
}

bool ProgressiveHull::may_collapse(const Candidate& edge)
{
    const std::vector<int> ring_a = ring(edge.a), ring_b = ring(edge.b);
    std::vector<int> both;
    std::ranges::set_intersection(ring_a, ring_b, std::back_inserter(both));
    const auto sides =
        std::ranges::count_if(around_[edge.a], [&](int f) { return contains(faces_[f], edge.b); });
    // The link condition. Where both vertices are on the mirror, the edge must lie on it, too.
    if (static_cast<std::ptrdiff_t>(both.size()) != sides ||
        sides != (on_mirror(edge.a) && on_mirror(edge.b) ? 1 : 2))
        return false;
    const std::vector<int> replaced = faces_around(edge.a, edge.b);
    if (replaced.size() < (sides == 2 ? 6u : 3u))
        return false;

    Fan fan;
    for (int f : replaced) {
        Triangle indices = faces_[f];
        if (contains(indices, edge.a) && contains(indices, edge.b))
            continue;
        Corners before = corners_of(points_, indices), after = before;
        for (int k = 0; k < 3; ++k)
            if (indices[k] == edge.a || indices[k] == edge.b) {
                after[k] = edge.point;
                indices[k] = edge.a;
            }
        const Vector3 n = area_of(after), old = area_of(before);
        if (n.dot(old) < least_cosine * n.norm() * old.norm() ||
            shape(after) < std::min(least_shape, 0.7 * shape(before)))
            return false;
        fan.corners.push_back(after);
        fan.indices.push_back(indices);
    }
    return keeps_mirror(fan, edge.a, on_mirror(edge.a) || on_mirror(edge.b)) && stays_embedded(fan, replaced);
}

/// Vertex a takes the place of both.
void ProgressiveHull::collapse(const Candidate& edge)
{
    for (int f : around_[edge.b]) {
        if (contains(faces_[f], edge.a)) {
            alive_[f] = 0;
            --face_count_;
            for (int v : faces_[f])
                if (v != edge.b)
                    std::erase(around_[v], f);
        } else {
            std::ranges::replace(faces_[f], edge.b, edge.a);
            around_[edge.a].push_back(f);
        }
    }
    around_[edge.b].clear();
    points_[edge.a] = edge.point;
    for (int f : around_[edge.a]) {
        boxes_[f].setEmpty();
        for (int v : faces_[f])
            boxes_[f].extend(points_[v]);
    }
    const std::vector<int> changed = ring(edge.a);
    ++stamps_[edge.a];
    for (int v : changed)
        ++stamps_[v];
    std::set<std::pair<int, int>> edges;
    for (int v : changed) {
        edges.insert(std::minmax(v, edge.a));
        for (int w : ring(v))
            edges.insert(std::minmax(v, w));
    }
    for (const auto& [v, w] : edges)
        propose(v, w);
}

void ProgressiveHull::collapse(int faces, const Progress& progress)
{
    queue_ = {};
    for (int v = 0; v < static_cast<int>(points_.size()); ++v)
        for (int w : ring(v))
            if (v < w)
                propose(v, w);
    const int first = face_count_;
    for (int done = 0; face_count_ > faces && !queue_.empty();) {
        const Candidate edge = queue_.top();
        queue_.pop();
        if (around_[edge.a].empty() || around_[edge.b].empty() ||
            edge.stamp != stamps_[edge.a] + stamps_[edge.b] || !may_collapse(edge))
            continue;
        collapse(edge);
        if (++done % 128 == 0) {
            progress.tick(static_cast<double>(first - face_count_) / std::max(1, first - faces),
                          "simplifying");
            renew_boxes(); // leaves out the faces that are gone
        }
    }
    renew_boxes();
}

/// Whether a vertex may move without touching `within` or the surface on its way.
bool ProgressiveHull::may_move(int vertex, const Vector3& to, const TriangleTree& within)
{
    if (mirror_axis_ >= 0 && !on_mirror(vertex) && to[mirror_axis_] < 0.5 * points_[vertex][mirror_axis_])
        return false;
    Fan fan;
    double before = 1.0, after = 1.0;
    for (int f : around_[vertex]) {
        const Corners old = corners_of(points_, faces_[f]);
        Corners fresh = old;
        for (int k = 0; k < 3; ++k)
            if (faces_[f][k] == vertex)
                fresh[k] = to;
        if (area_of(fresh).dot(area_of(old)) < 0.0)
            return false;
        before = std::min(before, shape(old));
        after = std::min(after, shape(fresh));
        fan.corners.push_back(fresh);
        fan.indices.push_back(faces_[f]);
    }
    if (after < std::min(0.15, before))
        return false;
    // The space that the fan sweeps over is bounded by the old fan, the new fan and these triangles.
    for (int v : ring(vertex))
        if (within.meets({points_[vertex], to, points_[v]}))
            return false;
    return std::ranges::none_of(fan.corners, [&](const Corners& t) { return within.meets(t); }) &&
           stays_embedded(fan, around_[vertex]);
}

void ProgressiveHull::tighten(const TriangleTree& within, const Progress& progress)
{
    constexpr int rounds = 4;
    for (int round = 0; round < rounds; ++round) {
        progress.tick(static_cast<double>(round) / rounds, "tightening");
        for (int v = 0; v < static_cast<int>(points_.size()); ++v) {
            if (around_[v].empty())
                continue;
            const Vector3 pull = within.closest(points_[v]) - points_[v];
            const std::vector<int> neighbours = ring(v);
            Vector3 slide = Vector3::Zero(), normal = Vector3::Zero();
            for (int w : neighbours)
                slide += (points_[w] - points_[v]) / static_cast<double>(neighbours.size());
            for (int f : around_[v])
                normal += area(f);
            normal.normalize();
            slide -= normal * normal.dot(slide);
            const Vector3 steps[] = {0.6 * pull + 0.3 * slide, 0.6 * pull, 0.3 * pull, 0.1 * pull,
                                     0.3 * slide};
            for (Vector3 step : steps) {
                if (on_mirror(v))
                    step[mirror_axis_] = 0.0;
                if (!may_move(v, points_[v] + step, within))
                    continue;
                points_[v] += step;
                for (int f : around_[v]) {
                    boxes_[f].setEmpty();
                    for (int w : faces_[f])
                        boxes_[f].extend(points_[w]);
                }
                break;
            }
        }
    }
}

TriangleSoup ProgressiveHull::surface() const
{
    TriangleSoup left;
    std::vector<int> place(points_.size(), -1);
    for (std::size_t v = 0; v < points_.size(); ++v)
        if (!around_[v].empty()) {
            place[v] = static_cast<int>(left.points.size());
            left.points.push_back(points_[v]);
        }
    for (std::size_t f = 0; f < faces_.size(); ++f)
        if (alive_[f])
            left.triangles.push_back({place[faces_[f][0]], place[faces_[f][1]], place[faces_[f][2]]});
    return left;
}

} // namespace sinew
