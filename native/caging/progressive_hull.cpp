// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/caging/progressive_hull.h"

#include "native/core/dense.h"

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

constexpr double closeness = 0.03; // weight of the distance to the edge's middle, where the planes have 1
// Between the normals before and after a collapse: 78 degrees, or 120 where it is bold.
constexpr double least_cosine[] = {0.2, -0.5};
constexpr double least_solid_angle = 1.0; // of a vertex after a collapse, unless it is bold: no spikes
constexpr double least_shape = 0.1; // of a triangle; an equilateral one has 1
constexpr double good_shape =
    0.3; // below this, a triangle may not become worse while the surface is tightened
constexpr double springs = 0.05; // weight of the squared lengths, where the volume has 1
constexpr double fold_cosine = -0.97; // between the normals of neighbours: 14 degrees from a fold
// How far from its edge a new vertex may be, as a share of the size; the second where it is bold.
constexpr double farthest[] = {0.25, 0.45};

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
        const Eigen::Matrix<double, Dim, 1> b = span.transpose() * (H * (centre - origin));
        if constexpr (Dim == 1)
            p = origin + span * (b / A(0, 0));
        else
            p = origin + span * solve_symmetric(A, b);
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

ProgressiveHull::ProgressiveHull(TriangleSoup surface, double size, int mirror_axis, Fineness fineness)
    : points_(std::move(surface.points)), faces_(std::move(surface.triangles)), alive_(faces_.size(), 1),
      around_(points_.size()), stamps_(points_.size(), 0), size_(size), mirror_axis_(mirror_axis),
      fineness_(std::move(fineness)), face_count_(static_cast<int>(faces_.size()))
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
        renew_box(f);
    }
}

void ProgressiveHull::renew_box(int face)
{
    boxes_[face].setEmpty();
    for (int v : faces_[face])
        boxes_[face].extend(points_[v]);
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
    const Vector3 centre = solve_symmetric(H, h);
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
    if (p.norm() > farthest[bold_] * size_)
        return;
    const double finer = std::pow(fineness_.at(middle), 4); // as costs grow with that power of lengths
    const double cost = finer * (p.dot(H * p) - 2.0 * h.dot(p) + constant);
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

/// The solid angle inside the surface at a vertex with these faces: small at the tip of a spike, negative in
/// a pit.
double ProgressiveHull::solid_angle(const Fan& fan, int vertex, bool on) const
{
    Vector3 in = Vector3::Zero();
    for (const Corners& t : fan.corners)
        in -= area_of(t);
    if (on)
        in[mirror_axis_] = 0.0; // so what the mirror cuts off has no angle of its own
    in.normalize();
    double sum = 0.0;
    for (std::size_t i = 0; i < fan.corners.size(); ++i) {
        const auto k = std::ranges::find(fan.indices[i], vertex) - fan.indices[i].begin();
        const Corners& t = fan.corners[i];
        const Vector3 a = (t[(k + 1) % 3] - t[k]).normalized(), b = (t[(k + 2) % 3] - t[k]).normalized();
        sum -= 2.0 * std::atan2(in.dot(a.cross(b)), 1.0 + a.dot(b) + b.dot(in) + in.dot(a));
    }
    return on ? 2.0 * sum : sum;
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
        if (n.dot(old) < least_cosine[bold_] * n.norm() * old.norm() ||
            shape(after) < std::min(least_shape, 0.7 * shape(before)))
            return false;
        fan.corners.push_back(after);
        fan.indices.push_back(indices);
    }
    const bool on = on_mirror(edge.a) || on_mirror(edge.b);
    const double angle = solid_angle(fan, edge.a, on);
    return (bold_ || angle < 0.0 || angle > least_solid_angle) && keeps_mirror(fan, edge.a, on) &&
           stays_embedded(fan, replaced);
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
    for (int f : around_[edge.a])
        renew_box(f);
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

void ProgressiveHull::collapse(int faces, bool boldly, const Progress& progress)
{
    bold_ = boldly;
    queue_ = {};
    for (int v = 0; v < static_cast<int>(points_.size()); ++v)
        for (int w : ring(v))
            if (v < w)
                propose(v, w);
    const int first = face_count_;
    progress.tick(0.0, "simplifying");
    // An edge on the mirror takes one face along, another edge two. Where one is too many, the others wait.
    std::vector<Candidate> waiting;
    for (int done = 0; face_count_ > faces && !queue_.empty();) {
        const Candidate edge = queue_.top();
        queue_.pop();
        if (around_[edge.a].empty() || around_[edge.b].empty() ||
            edge.stamp != stamps_[edge.a] + stamps_[edge.b])
            continue;
        if (mirror_axis_ >= 0 && face_count_ == faces + 1 && !(on_mirror(edge.a) && on_mirror(edge.b))) {
            waiting.push_back(edge);
            continue;
        }
        if (!may_collapse(edge))
            continue;
        collapse(edge);
        if (++done % 128 == 0) {
            progress.tick(static_cast<double>(first - face_count_) / std::max(1, first - faces),
                          "simplifying");
            renew_boxes(); // leaves out the faces that are gone
        }
    }
    if (face_count_ > faces)
        if (const auto edge =
                std::ranges::find_if(waiting, [&](const Candidate& e) { return may_collapse(e); });
            edge != waiting.end())
            collapse(*edge);
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
    if (after < std::min(good_shape, before))
        return false;
    // The space that the fan sweeps over is bounded by the old fan, the new fan and these triangles.
    for (int v : ring(vertex))
        if (within.meets({points_[vertex], to, points_[v]}))
            return false;
    return std::ranges::none_of(fan.corners, [&](const Corners& t) { return within.meets(t); }) &&
           stays_embedded(fan, around_[vertex]);
}

/// Moves a vertex to where the energy of its surroundings is least, or as far that way as it may.
bool ProgressiveHull::relax(int v, double stiffness, const TriangleTree& within)
{
    // The energy is volume . p + stiffness (total |p|^2 - 2 sum . p) and a constant.
    Vector3 volume = Vector3::Zero(), sum = Vector3::Zero();
    for (int f : around_[v]) {
        const Triangle& t = faces_[f];
        const int k = static_cast<int>(std::ranges::find(t, v) - t.begin());
        volume += points_[t[(k + 1) % 3]].cross(points_[t[(k + 2) % 3]]) / 6.0;
    }
    double total = 0.0;
    for (int w : ring(v)) {
        const double weight = on_mirror(v) && on_mirror(w) ? 0.5 : 1.0; // the image has the edge, too
        total += weight;
        sum += weight * points_[w];
    }
    const Vector3 p = points_[v];
    Vector3 way = (sum - volume / (2.0 * stiffness)) / total - p;
    if (on_mirror(v))
        way[mirror_axis_] = 0.0;
    Vector3 normal = Vector3::Zero();
    for (int f : around_[v])
        normal += area(f);
    normal.normalize();
    const Vector3 across = normal * normal.dot(way), along = way - across;
    const auto energy = [&](const Vector3& q) {
        return volume.dot(q) + stiffness * (total * q.squaredNorm() - 2.0 * sum.dot(q));
    };
    const double now = energy(p), least = 1e-6 * stiffness * size_ * size_;
    for (const Vector3& step : {way, Vector3(0.4 * way), Vector3(0.1 * way), Vector3(0.3 * across),
                                Vector3(0.1 * across), Vector3(0.3 * along)}) {
        Vector3 to = p + step;
        if (on_mirror(v))
            to[mirror_axis_] = 0.0;
        if (energy(to) > now - least || !may_move(v, to, within))
            continue;
        points_[v] = to;
        for (int f : around_[v])
            renew_box(f);
        return true;
    }
    return false;
}

/// Turns the edge between two faces the other way if that lowers the energy.
bool ProgressiveHull::flip(int a, int b, double stiffness, const TriangleTree& within)
{
    std::vector<int> both;
    for (int f : around_[a])
        if (contains(faces_[f], b))
            both.push_back(f);
    if (both.size() != 2)
        return false;
    const auto follows = [&](const Triangle& t) {
        return t[(std::ranges::find(t, a) - t.begin() + 1) % 3] == b;
    };
    if (!follows(faces_[both[0]]))
        std::swap(both[0], both[1]);
    const auto apex = [&](const Triangle& t) { return t[0] + t[1] + t[2] - a - b; };
    const int c = apex(faces_[both[0]]), d = apex(faces_[both[1]]); // faces (a, b, c) and (b, a, d)
    if (around_[a].size() < 4 || around_[b].size() < 4 || contains(ring(c), d) ||
        (on_mirror(c) && on_mirror(d)))
        return false;
    const auto volume = [&](int i, int j, int k) {
        return points_[i].dot(points_[j].cross(points_[k])) / 6.0;
    };
    const double change =
        volume(a, d, c) + volume(d, b, c) - volume(a, b, c) - volume(b, a, d) +
        stiffness * ((points_[c] - points_[d]).squaredNorm() - (points_[a] - points_[b]).squaredNorm());
    if (change > -1e-7 * stiffness * size_ * size_)
        return false;
    Fan fan;
    fan.indices = {Triangle{a, d, c}, Triangle{d, b, c}};
    double before = 1.0, after = 1.0;
    for (const Triangle& t : fan.indices) {
        fan.corners.push_back(corners_of(points_, t));
        after = std::min(after, shape(fan.corners.back()));
    }
    for (int f : both)
        before = std::min(before, shape(corners_of(points_, faces_[f])));
    if (after < std::min(good_shape, before) ||
        std::ranges::any_of(
            fan.corners, [&](const Corners& t) { return within.meets(t); }) ||
        !stays_embedded(fan, both))
        return false;
    std::erase(around_[b], both[0]);
    std::erase(around_[a], both[1]);
    around_[d].push_back(both[0]);
    around_[c].push_back(both[1]);
    for (int k : {0, 1}) {
        faces_[both[k]] = fan.indices[k];
        renew_box(both[k]);
    }
    return true;
}

void ProgressiveHull::tighten(const TriangleTree& within, int rounds, const Progress& progress)
{
    restless_.assign(points_.size(), 1);
    for (int round = 0; round < rounds; ++round) {
        progress.tick(static_cast<double>(round) / rounds, "tightening");
        std::vector<std::pair<int, int>> edges;
        double length = 0.0;
        for (int v = 0; v < static_cast<int>(points_.size()); ++v)
            for (int w : ring(v))
                if (v < w) {
                    edges.emplace_back(v, w);
                    length += (points_[v] - points_[w]).norm();
                }
        const double stiffness = springs * length / static_cast<double>(edges.size());
        const std::vector<char> asked = std::exchange(restless_, std::vector<char>(points_.size(), 0));
        const auto disturb = [&](int v) {
            restless_[v] = 1;
            for (int w : ring(v))
                restless_[w] = 1;
        };
        for (int v = 0; v < static_cast<int>(points_.size()); ++v)
            if (asked[v] && !around_[v].empty() && relax(v, stiffness, within))
                disturb(v);
        for (const auto& [a, b] : edges)
            if ((asked[a] || asked[b]) && flip(a, b, stiffness, within)) {
                disturb(a);
                disturb(b);
            }
        if (std::ranges::find(restless_, 1) == restless_.end())
            break;
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
