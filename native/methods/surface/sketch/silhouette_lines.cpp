// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/sketch/silhouette_lines.h"

#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/mesh/half_edges.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <utility>

namespace sinew {

namespace {

using Place = Eigen::Vector2d;
using Segment = std::array<int, 2>;

constexpr double least_depth = 1e-9; ///< as a share of the distance to the viewer
constexpr double same_place = 1e-9;  ///< as a share of the length of a line
constexpr double edge_on = 1e-6; ///< n . v of unit vectors that are at right angles, up to single precision
constexpr int samples = 64; ///< at which a stroke and a part of a line are compared

/// The polylines of segments between nodes. They end at nodes of more or fewer than two segments.
std::vector<SurfaceLine> traced(const std::vector<LinePoint>& nodes, std::vector<Segment> segments)
{
    for (Segment& segment : segments)
        std::ranges::sort(segment);
    std::ranges::sort(segments);
    const auto doubled = std::ranges::unique(segments);
    segments.erase(doubled.begin(), doubled.end());
    std::vector<std::vector<int>> at(nodes.size());
    for (int s = 0; s < static_cast<int>(segments.size()); ++s)
        for (int node : segments[s])
            at[node].push_back(s);

    std::vector<SurfaceLine> found;
    std::vector<bool> used(segments.size(), false);
    const auto walk = [&](int node, int segment) {
        SurfaceLine line;
        const int first = node;
        line.points.push_back(nodes[node]);
        while (segment >= 0) {
            used[segment] = true;
            node = segments[segment][0] == node ? segments[segment][1] : segments[segment][0];
            if (node == first) {
                line.closed = true;
                break;
            }
            line.points.push_back(nodes[node]);
            const std::vector<int>& next = at[node];
            if (next.size() != 2)
                break;
            segment = used[next[0]] ? next[1] : next[0];
            if (used[segment])
                break;
        }
        found.push_back(std::move(line));
    };
    for (const bool loops : {false, true})
        for (int node = 0; node < static_cast<int>(nodes.size()); ++node)
            if (loops || at[node].size() != 2)
                for (int segment : at[node])
                    if (!used[segment])
                        walk(node, segment);
    return found;
}

bool is_before(const SketchView& view, const Vector3& x)
{
    return view.depth(x) > least_depth * (view.eye ? (*view.eye - x).norm() : 0.0);
}

/// The vertices of edges as nodes, without edges that reach behind the viewer.
std::vector<SurfaceLine> traced_edges(const SurfaceMesh& mesh, std::span<const Segment> edges,
                                      const SketchView& view)
{
    std::vector<LinePoint> nodes(mesh.vertex_count());
    for (int v = 0; v < mesh.vertex_count(); ++v)
        nodes[v] = {v, v, 0.0};
    std::vector<Segment> segments;
    for (const Segment& edge : edges)
        if (edge[0] != edge[1] && is_before(view, mesh.point(edge[0])) &&
            is_before(view, mesh.point(edge[1])))
            segments.push_back(edge);
    return traced(nodes, std::move(segments));
}

/// (n) n . v at the vertices; 0 where it is no more than rounding.
VectorX facing(const SurfaceMesh& mesh, const SketchView& view)
{
    Points normals = Points::Zero(mesh.vertex_count(), 3);
    for (const Triangle& t : mesh.triangles())
        for (int k = 0; k < 3; ++k) {
            const Vector3 a = mesh.point(t[(k + 1) % 3]) - mesh.point(t[k]),
                          b = mesh.point(t[(k + 2) % 3]) - mesh.point(t[k]);
            const double squares = a.squaredNorm() * b.squaredNorm();
            if (squares > 0)
                normals.row(t[k]) += a.cross(b).transpose() / squares;
        }
    VectorX found(mesh.vertex_count());
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        const Vector3 toward = view.toward(mesh.point(v));
        const double g = normals.row(v).transpose().stableNormalized().dot(toward);
        found[v] = std::abs(g) > edge_on * toward.norm() ? g : 0.0;
    }
    return found;
}

/// A polyline on the screen.
class Path
{
public:
    Path(std::vector<Place> places, bool closed) : places_(std::move(places))
    {
        if (closed)
            places_.push_back(places_.front());
        arcs_.push_back(0.0);
        for (std::size_t k = 1; k < places_.size(); ++k)
            arcs_.push_back(arcs_.back() + (places_[k] - places_[k - 1]).norm());
    }

    double length() const { return arcs_.back(); }
    const Place& front() const { return places_.front(); }
    const Place& back() const { return places_.back(); }
    /// From the first place to the k-th.
    double arc(std::size_t k) const { return arcs_[k]; }

    Place at(double arc) const
    {
        const auto after = std::ranges::upper_bound(arcs_, arc);
        if (after == arcs_.end())
            return back();
        const auto k = std::max<std::ptrdiff_t>(after - arcs_.begin(), 1);
        const double step = arcs_[k] - arcs_[k - 1];
        const double share = step > 0 ? std::clamp((arc - arcs_[k - 1]) / step, 0.0, 1.0) : 0.0;
        return (1 - share) * places_[k - 1] + share * places_[k];
    }

    /// The arc of the place that is nearest to p, and its distance.
    std::pair<double, double> nearest(const Place& p) const
    {
        std::pair<double, double> best = {0.0, (p - front()).norm()};
        for (std::size_t k = 1; k < places_.size(); ++k) {
            const Place along = places_[k] - places_[k - 1];
            const double square = along.squaredNorm();
            const double share =
                square > 0 ? std::clamp((p - places_[k - 1]).dot(along) / square, 0.0, 1.0) : 0.0;
            const double distance = (p - places_[k - 1] - share * along).norm();
            if (distance < best.second)
                best = {arcs_[k - 1] + share * (arcs_[k] - arcs_[k - 1]), distance};
        }
        return best;
    }

private:
    std::vector<Place> places_;
    std::vector<double> arcs_;
};

/// The part of a path from one arc on, forwards or backwards, maybe across the end of a closed one.
struct Part
{
    double from, length;
    bool backwards;

    double arc(double share, double whole) const
    {
        const double arc = backwards ? from - share * length : from + share * length;
        return arc < 0 ? arc + whole : arc > whole ? arc - whole : arc;
    }

    /// The share of the part at an arc; above 1 outside.
    double share(double arc, double whole, bool closed) const
    {
        double way = backwards ? from - arc : arc - from;
        if (closed && way < -same_place * whole)
            way += whole;
        if (way < -same_place * whole || way > length + same_place * whole)
            return 2.0;
        return length > 0 ? std::clamp(way / length, 0.0, 1.0) : 2.0;
    }
};

std::vector<Part> parts_between(double first, double last, double whole, bool closed)
{
    if (!closed)
        return {{first, std::abs(last - first), last < first}};
    const double forwards = last >= first ? last - first : last - first + whole;
    return {{first, forwards, false},
            {first, whole - forwards, true},
            {first, whole, false},
            {first, whole, true}};
}

} // namespace

void SketchView::check() const
{
    if (!axes.allFinite() || (axes * axes.transpose() - Matrix3::Identity()).cwiseAbs().maxCoeff() > 1e-6)
        throw InvalidOption("axes: the rows are not three finite unit vectors at right angles");
    if (eye && !eye->allFinite())
        throw InvalidOption("eye: NaN or infinite coordinates");
}

std::vector<SurfaceLine> silhouette_lines(const SurfaceMesh& mesh, const SketchView& view)
{
    view.check();
    const VectorX g = facing(mesh, view);
    std::map<Segment, int> node_of;
    std::vector<LinePoint> nodes;
    std::vector<Segment> segments;
    for (const Triangle& t : mesh.triangles()) {
        Segment crossed = {-1, -1};
        int count = 0;
        for (int k = 0; k < 3; ++k) {
            const int a = std::min(t[k], t[(k + 1) % 3]), b = std::max(t[k], t[(k + 1) % 3]);
            if ((g[a] < 0) == (g[b] < 0))
                continue;
            const Segment edge = g[a] == 0 ? Segment{a, a} : g[b] == 0 ? Segment{b, b} : Segment{a, b};
            const auto [place, is_new] = node_of.try_emplace(edge, static_cast<int>(nodes.size()));
            if (is_new)
                nodes.push_back({edge[0], edge[1], edge[0] == edge[1] ? 0.0 : g[a] / (g[a] - g[b])});
            crossed[count++] = place->second;
        }
        if (count == 2 && crossed[0] != crossed[1] && std::ranges::all_of(crossed, [&](int node) {
                return is_before(view, nodes[node].on(sinew::view(mesh.points())));
            }))
            segments.push_back(crossed);
    }
    std::vector<SurfaceLine> found = traced(nodes, std::move(segments));

    std::vector<Segment> border;
    const std::vector<HalfEdge> sides = sorted_half_edges(mesh);
    for_each_edge(sides, [&](std::span<const HalfEdge> along) {
        if (along.size() == 1)
            border.push_back(along[0].edge());
    });
    std::ranges::move(traced_edges(mesh, border, view), std::back_inserter(found));
    return found;
}

std::vector<SurfaceLine> edge_lines(const SurfaceMesh& mesh, std::span<const Segment> edges,
                                    const SketchView& view)
{
    view.check();
    for (const Segment& edge : edges)
        for (int v : edge)
            if (v < 0 || v >= mesh.vertex_count())
                throw InvalidConstraint("edges: there is no vertex " + std::to_string(v),
                                        Error::Element::vertex, {v});
    return traced_edges(mesh, edges, view);
}

std::optional<StrokeFit> fit_stroke(const SurfaceMesh& mesh, std::span<const SurfaceLine> lines,
                                    const SketchView& view, const PointsView& stroke, double nearness,
                                    const std::function<bool(const LinePoint&)>& hidden)
{
    view.check();
    if (stroke.rows() < 2)
        throw InvalidConstraint("stroke: it has fewer than two points");
    if (!all_finite(stroke))
        throw InvalidConstraint("stroke: NaN or infinite coordinates");
    std::vector<Place> places;
    for (int k = 0; k < stroke.rows(); ++k) {
        const Vector3 x = stroke.row(k).transpose();
        if (!is_before(view, x))
            throw InvalidConstraint("stroke: a point is behind the viewer");
        places.push_back(view.seen(x));
    }
    const Path drawn(std::move(places), false);
    if (!(drawn.length() > 0))
        throw InvalidConstraint("stroke: it has no length in this view");

    double least = std::numeric_limits<double>::infinity();
    std::optional<StrokeFit> best;
    for (const SurfaceLine& line : lines) {
        std::vector<Place> seen;
        for (const LinePoint& point : line.points)
            seen.push_back(view.seen(point.on(sinew::view(mesh.points()))));
        const Path path(std::move(seen), line.closed);
        const auto [first, at_first] = path.nearest(drawn.front());
        const auto [last, at_last] = path.nearest(drawn.back());
        if (!(std::max(at_first, at_last) <= nearness * drawn.length()))
            continue;
        const double whole = path.length();
        std::vector<std::optional<bool>> known(line.points.size());
        const auto is_mostly_hidden = [&](const std::vector<std::pair<double, int>>& inside) {
            const auto count = std::ranges::count_if(inside, [&](const auto& point) {
                std::optional<bool>& found = known[point.second];
                if (hidden && !found)
                    found = hidden(line.points[point.second]);
                return found.value_or(false);
            });
            return 2 * count > static_cast<std::ptrdiff_t>(inside.size());
        };
        for (const Part& part : parts_between(first, last, whole, line.closed)) {
            double cost = 0.0;
            for (int k = 0; k <= samples; ++k) {
                const double share = static_cast<double>(k) / samples;
                cost += (drawn.at(share * drawn.length()) - path.at(part.arc(share, whole))).norm();
            }
            if (!(cost < least))
                continue;
            std::vector<std::pair<double, int>> inside;
            for (int k = 0; k < static_cast<int>(line.points.size()); ++k)
                if (const double share = part.share(path.arc(k), whole, line.closed); share <= 1)
                    inside.emplace_back(share, k);
            if (inside.empty() || is_mostly_hidden(inside))
                continue;
            least = cost;
            std::ranges::sort(inside);
            best.emplace();
            best->targets.resize(static_cast<Eigen::Index>(inside.size()), 3);
            for (const auto& [share, k] : inside) {
                const LinePoint& point = line.points[k];
                best->targets.row(static_cast<Eigen::Index>(best->points.size())) =
                    view.moved(point.on(sinew::view(mesh.points())), drawn.at(share * drawn.length()));
                best->points.push_back(point);
            }
        }
    }
    return best;
}

} // namespace sinew
