// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/nonlinear/graph/near_nodes.h"

#include "native/core/memory.h"
#include "native/core/parallel.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <queue>

namespace sinew {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
/// A part with a longer diagonal than this many spacings of nodes is measured along its surface.
constexpr double large_part = 4.0;
/// A node farther away than this many radii moves nothing.
constexpr double reach = 3.0;
/// How much farther than needed a front runs.
constexpr double beyond = 1.3;
constexpr int kept = NearNodes::count + 1;
/// The least share by which a distance has to become shorter. Among slivers, each gain sets off others, so it
/// doubles with every `patience` offers.
constexpr double least_gain = 1e-4;
constexpr int patience = 8;
constexpr int batch = 64; ///< nodes whose fronts run at once

/// The distance of `c` from the point in the plane, on the other side of the edge from a to b, that is as far
/// from these as they say, if the way to it crosses the edge; infinite otherwise.
double across(const Vector3& a, double at_a, const Vector3& b, double at_b, const Vector3& c)
{
    const Vector3 edge = b - a, side = c - a;
    const double length = edge.norm();
    if (!(length > 0.0))
        return infinite;
    const double source = 0.5 * (length + (at_a - at_b) * (at_a + at_b) / length);
    const double depth = std::sqrt(std::max(0.0, at_a * at_a - source * source));
    const double along = side.dot(edge) / length,
                 height = std::sqrt(std::max(0.0, side.squaredNorm() - along * along));
    if (!(depth + height > 0.0))
        return infinite;
    const double crossing = source + (along - source) * depth / (depth + height);
    return crossing > 0.0 && crossing < length ? std::hypot(along - source, depth + height) : infinite;
}

/// Distances that differ by rounding alone are equal, so that the order of the vertices decides between them.
/// On a regular mesh, the graph would change with each turn of its axes otherwise.
double tied(double distance) { return static_cast<float>(distance); }

double area_of(const SurfaceMesh& mesh)
{
    double sum = 0.0;
    for (const auto& [a, b, c] : mesh.triangles())
        sum += 0.5 * (mesh.point(b) - mesh.point(a)).cross(mesh.point(c) - mesh.point(a)).norm();
    return sum;
}

} // namespace

/// Distances along the surface from one vertex at a time.
class NearNodes::Fronts
{
public:
    explicit Fronts(const SurfaceMesh& mesh)
        : mesh_(mesh), offsets_(static_cast<std::size_t>(mesh.vertex_count()) + 1, 0),
          distance_(static_cast<std::size_t>(mesh.vertex_count()), infinite), times_(distance_.size(), 0)
    {
        for (const Triangle& triangle : mesh.triangles())
            for (const int v : triangle)
                ++offsets_[v + 1];
        for (std::size_t v = 1; v < offsets_.size(); ++v)
            offsets_[v] += offsets_[v - 1];
        triangles_.resize(offsets_.back());
        std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
        for (int t = 0; t < static_cast<int>(mesh.triangles().size()); ++t)
            for (const int v : mesh.triangles()[t])
                triangles_[next[v]++] = t;
    }

    /// Visits the vertices by rising distance from `source`, as long as they are nearer than bound(vertex).
    template <class Bound, class Visit>
    void from(int source, Bound&& bound, Visit&& visit)
    {
        open_ = {};
        reached_.clear();
        offer(source, 0.0, bound);
        while (!open_.empty()) {
            const auto [distance, v] = open_.top();
            open_.pop();
            if (distance > distance_[v] || !(distance < bound(v)))
                continue;
            for (int k = offsets_[v]; k < offsets_[v + 1]; ++k)
                cross(mesh_.triangles()[triangles_[k]], v, bound);
        }
        for (const int v : reached_)
            if (distance_[v] < bound(v))
                visit(v, distance_[v]);
        for (const int v : reached_)
            distance_[v] = infinite;
    }

private:
    template <class Bound>
    void offer(int v, double distance, Bound&& bound)
    {
        distance = tied(distance);
        if (!(distance < bound(v)))
            return;
        if (distance_[v] == infinite) {
            reached_.push_back(v);
            times_[v] = 0;
        } else if (!(distance < distance_[v] * (1.0 - std::ldexp(least_gain, times_[v]++ / patience)))) {
            return;
        }
        distance_[v] = distance;
        open_.emplace(distance, v);
    }

    template <class Bound>
    void cross(const Triangle& triangle, int v, Bound&& bound)
    {
        const Vector3 at = mesh_.point(v);
        for (int k = 0; k < 3; ++k) {
            const int to = triangle[k];
            if (to == v)
                continue;
            const Vector3 place = mesh_.point(to);
            double least = distance_[v] + (place - at).norm();
            for (const int other : triangle)
                if (other != v && other != to && distance_[other] < infinite)
                    least = std::min(least,
                                     across(at, distance_[v], mesh_.point(other), distance_[other], place));
            offer(to, least, bound);
        }
    }

    using Entry = std::pair<double, int>;
    const SurfaceMesh& mesh_;
    std::vector<int> offsets_, triangles_; ///< of each vertex
    std::vector<double> distance_;
    std::vector<int> times_; ///< that a shorter way to each vertex was offered
    std::vector<int> reached_;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open_;
};

NearNodes::NearNodes(const SurfaceMesh& mesh, int wanted, const Progress& progress)
    : mesh_(mesh), parts_(connected_components(mesh)), large_(static_cast<std::size_t>(parts_.count), 0)
{
    const double spacing = std::sqrt(area_of(mesh) / wanted);
    std::vector<Eigen::AlignedBox3d> boxes(static_cast<std::size_t>(parts_.count));
    for (int v = 0; v < mesh.vertex_count(); ++v)
        boxes[parts_.labels[v]].extend(mesh.point(v));
    std::vector<char> has_faces(static_cast<std::size_t>(parts_.count), 0);
    for (const Triangle& triangle : mesh.triangles())
        has_faces[parts_.labels[triangle[0]]] = 1;
    for (int p = 0; p < parts_.count; ++p)
        large_[p] = has_faces[p] && boxes[p].diagonal().norm() > large_part * spacing;
    choose(wanted, progress);
    find_near(progress);
}

void NearNodes::choose(int wanted, const Progress& progress)
{
    Fronts fronts(mesh_);
    const int n = mesh_.vertex_count();
    std::vector<double> near(static_cast<std::size_t>(n), infinite);
    std::vector<int> loose;
    std::vector<char> begun(large_.begin(), large_.end()); // 1 for a large part without a node
    auto unreached = std::ranges::count(large_, 1);
    for (int v = 0; v < n; ++v)
        if (!is_on_surface(v))
            loose.push_back(v);
    // Begins at the far end of a large part, so that no small one gets a node for nothing.
    const Vector3 centre = mesh_.points().colwise().mean().transpose();
    int next = 0;
    std::pair<bool, double> best{false, -1.0};
    for (int v = 0; v < n; ++v)
        if (const std::pair here{is_on_surface(v), tied((mesh_.point(v) - centre).norm())}; here > best) {
            best = here;
            next = v;
        }
    while (true) {
        if (nodes_.size() % 64 == 0)
            progress.tick(0.4 * std::min(1.0, static_cast<double>(nodes_.size()) / wanted), "placing nodes");
        nodes_.push_back(next);
        const Vector3 at = mesh_.point(next);
        if (is_on_surface(next)) {
            unreached -= begun[part(next)];
            begun[part(next)] = 0;
            fronts.from(
                next, [&](int v) { return near[v]; }, [&](int v, double distance) { near[v] = distance; });
        }
        near[next] = 0.0;
        parallel_for(static_cast<int>(loose.size()), [&](int k) {
            near[loose[k]] = std::min(near[loose[k]], tied((mesh_.point(loose[k]) - at).norm()));
        });
        const auto farthest = std::ranges::max_element(near);
        radius_ = *farthest;
        next = static_cast<int>(farthest - near.begin());
        if (!(radius_ > 0.0) || (unreached == 0 && static_cast<int>(nodes_.size()) >= wanted))
            break;
    }
}

void NearNodes::find_near(const Progress& progress)
{
    const int n = mesh_.vertex_count();
    const double farthest = radius_ > 0.0 ? reach * radius_ : infinite;
    near_.assign(static_cast<std::size_t>(n) * kept, {farthest, -1});
    const auto put = [&](int v, double distance, int node) {
        Near* const own = near_.data() + static_cast<std::size_t>(v) * kept;
        int k = kept - 1;
        if (!(distance < own[k].first))
            return;
        for (; k > 0 && distance < own[k - 1].first; --k)
            own[k] = own[k - 1];
        own[k] = {distance, node};
    };
    // A node that is not among the nearest of a vertex is not of those behind it, either; but a front that
    // crosses an edge needs both of its ends. What counts is what the batches before have found.
    const auto bound = [&](int v) {
        return beyond * near_[static_cast<std::size_t>(v) * kept + kept - 1].first;
    };
    Pool<Fronts> fronts;
    std::vector<std::vector<std::pair<int, double>>> reached(batch);
    for (int first = 0; first < static_cast<int>(nodes_.size()); first += batch) {
        progress.tick(0.4 + 0.3 * first / static_cast<double>(nodes_.size()), "measuring distances");
        const int some = std::min(batch, static_cast<int>(nodes_.size()) - first);
        parallel_chunks(some, 4, [&](int begin, int end) {
            const auto own = fronts.take([&] { return std::make_unique<Fronts>(mesh_); });
            for (int k = begin; k < end; ++k) {
                reached[k].clear();
                if (is_on_surface(nodes_[first + k]))
                    own->from(nodes_[first + k], bound,
                              [&](int v, double distance) { reached[k].emplace_back(v, distance); });
            }
        });
        for (int k = 0; k < some; ++k)
            for (const auto& [v, distance] : reached[k])
                put(v, distance, first + k);
    }
    parallel_for(
        n,
        [&](int v) {
            if (!is_on_surface(v))
                for (int j = 0; j < static_cast<int>(nodes_.size()); ++j)
                    put(v, tied((mesh_.point(nodes_[j]) - mesh_.point(v)).norm()), j);
        },
        64);
}

std::vector<BlendedMaps::Share> NearNodes::weighed(const Near* near, int found) const
{
    double farthest = near[kept - 1].first;
    if (farthest == infinite) // there are fewer nodes than that
        farthest = 2.0 * near[found - 1].first;
    std::vector<BlendedMaps::Share> shares;
    double sum = 0.0;
    for (int k = 0; k < std::min(found, count); ++k) {
        const double falling = farthest > 0.0 ? 1.0 - near[k].first / farthest : 0.0;
        if (falling > 0.0) {
            shares.push_back({near[k].second, falling * falling});
            sum += falling * falling;
        }
    }
    if (shares.empty()) { // all nodes are equally far
        for (int k = 0; k < std::min(found, count); ++k)
            shares.push_back({near[k].second, 1.0});
        sum = static_cast<double>(shares.size());
    }
    for (BlendedMaps::Share& share : shares)
        share.weight /= sum;
    return shares;
}

std::vector<BlendedMaps::Share> NearNodes::shares(int vertex) const
{
    const Near* const own = near_.data() + static_cast<std::size_t>(vertex) * kept;
    const int found =
        static_cast<int>(std::count_if(own, own + kept, [](const Near& near) { return near.second >= 0; }));
    return found > 0 ? weighed(own, found) : straight_shares(mesh_.point(vertex));
}

std::vector<BlendedMaps::Share> NearNodes::straight_shares(const Vector3& place) const
{
    std::vector<Near> all;
    for (int j = 0; j < static_cast<int>(nodes_.size()); ++j)
        all.emplace_back(tied((mesh_.point(nodes_[j]) - place).norm()), j);
    const int found = std::min(kept, static_cast<int>(all.size()));
    std::partial_sort(all.begin(), all.begin() + found, all.end());
    std::array<Near, kept> near;
    near.fill({radius_ > 0.0 ? std::max(reach * radius_, 2.0 * all[0].first) : infinite, -1});
    std::copy(all.begin(), all.begin() + found, near.begin());
    return weighed(near.data(), found);
}

} // namespace sinew
