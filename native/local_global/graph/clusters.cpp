// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/graph/clusters.h"

#include "native/core/parallel.h"
#include "native/mesh/frames/surface_frame.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <queue>
#include <utility>

namespace sinew {

namespace {

constexpr double hat_radius = 1.6; ///< how far the shares of a cluster reach, in cluster radii
constexpr int seeds_per_tick = 512;
constexpr double infinite = std::numeric_limits<double>::infinity();

using Entry = std::pair<double, int>;
using Front = std::priority_queue<Entry, std::vector<Entry>, std::greater<>>;

/// A length rounded to a multiple of an eighth of the power of two below it, and raised by a sixteenth, so
/// that it is no shorter than it was. Sums of such numbers are exact, and the bounds between them lie where
/// no regular mesh has its lengths.
double rounded(double length)
{
    constexpr std::uint64_t eighth = std::uint64_t{1} << 49; // of an octave, in the bits of a double
    constexpr auto below = static_cast<std::uint64_t>(0.54 * eighth); // a bound is this far below a multiple
    if (!(length > 0))
        return 0.0;
    return 1.0625 * std::bit_cast<double>((std::bit_cast<std::uint64_t>(length) + below) & ~(eighth - 1));
}

/// Visits nodes in the order of their distance from a seed along the edges.
/// \param lengths   (edges) as long as each of them counts.
/// \param distance  (nodes) the distances that `reaches` has noted.
/// \param visit     visit(node, distance)
/// \param reaches   reaches(node, distance) says whether the walk goes on to a node; if so, it has noted the
///                  distance.
template <class Visit, class Reaches>
void grow(const GraphEdges& edges, const std::vector<double>& lengths, int seed,
          const std::vector<double>& distance, Visit&& visit, Reaches&& reaches)
{
    Front front;
    front.emplace(0.0, seed);
    while (!front.empty()) {
        const auto [d, i] = front.top();
        front.pop();
        if (d > distance[i])
            continue;
        visit(i, d);
        for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a) {
            const int j = edges.neighbours[a];
            const double further = d + lengths[a];
            if (reaches(j, further))
                front.emplace(further, j);
        }
    }
}

/// The frame of a graph by its edges, so that loose nodes count nothing, and idle parts neither.
SurfaceFrame frame_of(const HandleGraph& graph, const Points& rest)
{
    const GraphEdges& edges = graph.edges();
    std::vector<Vector3> middles;
    std::vector<double> lengths;
    for (int i = 0; i < edges.size(); ++i)
        for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a)
            if (const int j = edges.neighbours[a]; i < j && !graph.is_idle(i)) {
                middles.emplace_back(0.5 * (rest.row(i) + rest.row(j)).transpose());
                lengths.push_back((rest.row(i) - rest.row(j)).norm());
            }
    const bool any = std::ranges::any_of(lengths, [](double length) { return length > 0.0; });
    return any ? frame_of_points(middles, lengths) : SurfaceFrame{};
}

} // namespace

Clusters::Clusters(const HandleGraph& graph, const Points& rest, int wanted, const Progress& progress)
    : label(graph.size(), -1)
{
    const SurfaceFrame frame = frame_of(graph, rest);
    unit = frame.size;
    const GraphEdges& edges = graph.edges();
    lengths.resize(edges.neighbours.size());
    parallel_for(graph.size(), [&](int i) {
        for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a)
            lengths[a] = rounded((rest.row(i) - rest.row(edges.neighbours[a])).norm() / unit);
    });
    std::vector<double> distance(graph.size(), infinite);
    const auto add = [&](int seed) {
        const int id = static_cast<int>(seeds.size());
        if (id % seeds_per_tick == 0)
            progress.tick(0.0, "clustering");
        seeds.push_back(seed);
        distance[seed] = 0.0;
        label[seed] = id;
        grow(
            edges, lengths, seed, distance, [](int, double) {},
            [&](int j, double further) {
                if (graph.hard(j) != graph.hard(seed) || !(further < distance[j]))
                    return false;
                distance[j] = further;
                label[j] = id;
                return true;
            });
    };
    const std::vector<int> by_rank = order_by_place(view(rest), frame), ranks = new_numbers(by_rank);
    for (int i : by_rank)
        if (!graph.is_idle(i) && label[i] < 0)
            add(i); // each part of each region needs a seed
    std::priority_queue<Entry> farthest; // the second is minus the rank, so that the lowest comes first
    for (int i : by_rank)
        if (!graph.is_idle(i))
            farthest.emplace(distance[i], -ranks[i]);
    while (static_cast<int>(seeds.size()) < wanted && !farthest.empty()) {
        const auto [d, minus] = farthest.top();
        const int i = by_rank[-minus];
        farthest.pop();
        if (d > distance[i]) {
            farthest.emplace(distance[i], minus); // a seed added since then is nearer
            continue;
        }
        if (d <= 0)
            break;
        radius = d;
        add(i);
    }
}

/// The share of a cluster at a node is the square of a hat function of the node's distance from the seed
/// along the edges; at every node the shares are divided by their sum.
ClusterMap::ClusterMap(const HandleGraph& graph, const Clusters& clusters, const Progress& progress)
    : label_(clusters.label)
{
    collect_nodes(static_cast<int>(clusters.seeds.size()));

    const double reach = hat_radius * clusters.radius;
    std::vector<std::vector<std::pair<int, double>>> shares(graph.size());
    std::vector<double> distance(graph.size(), infinite);
    std::vector<int> touched;
    for (int s = 0; s < cluster_count(); ++s) {
        const int seed = clusters.seeds[s];
        if (s % seeds_per_tick == 0)
            progress.tick(0.0, "clustering");
        distance[seed] = 0.0;
        touched = {seed};
        grow(
            graph.edges(), clusters.lengths, seed, distance,
            [&](int i, double d) {
                const double height = reach > 0 ? 1.0 - d / reach : 1.0;
                shares[i].emplace_back(s, height * height);
            },
            [&](int j, double further) {
                if (!(further < reach && further < distance[j]))
                    return false;
                if (distance[j] == infinite)
                    touched.push_back(j);
                distance[j] = further;
                return true;
            });
        for (int i : touched)
            distance[i] = infinite;
    }
    for (int i = 0; i < graph.size(); ++i) {
        if (shares[i].empty() && label_[i] >= 0)
            shares[i].emplace_back(label_[i], 1.0);
        double sum = 0.0;
        for (const auto& share : shares[i])
            sum += share.second;
        for (const auto& [cluster, weight] : shares[i]) {
            clusters_.push_back(cluster);
            weights_.push_back(weight / sum);
        }
        offsets_.push_back(static_cast<int>(clusters_.size()));
    }
}

void ClusterMap::collect_nodes(int clusters)
{
    members_.assign(clusters + 1, 0);
    for (int p : label_)
        if (p >= 0)
            ++members_[p + 1];
    std::partial_sum(members_.begin(), members_.end(), members_.begin());
    nodes_.resize(members_.back());
    std::vector<int> next(members_.begin(), members_.end() - 1);
    for (int i = 0; i < static_cast<int>(label_.size()); ++i)
        if (label_[i] >= 0)
            nodes_[next[label_[i]]++] = i;
}

void ClusterMap::restrict(const PointsView& points, Points& means) const
{
    means.resize(cluster_count(), 3);
    parallel_for(
        cluster_count(),
        [&](int p) {
            Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
            for (int i : nodes(p))
                sum += points.row(i);
            means.row(p) = sum / static_cast<double>(nodes(p).size());
        },
        256);
}

std::vector<double> ClusterMap::restrict(const std::vector<double>& values) const
{
    std::vector<double> means(cluster_count());
    for (int p = 0; p < cluster_count(); ++p) {
        double sum = 0.0;
        for (int i : nodes(p))
            sum += values[i];
        means[p] = sum / static_cast<double>(nodes(p).size());
    }
    return means;
}

void ClusterMap::renumber(const std::vector<int>& old)
{
    const std::vector<int> renamed = new_numbers(old);
    for (int& p : label_)
        p = p < 0 ? p : renamed[p];
    for (int& p : clusters_)
        p = renamed[p];
    collect_nodes(cluster_count());
}

HandleGraph graph_of_clusters(const HandleGraph& graph, const Points& rest, const ClusterMap& map)
{
    const int size = map.cluster_count();
    const std::vector<int>& label = map.label();
    const Points means = map.restrict(view(rest));
    const GraphEdges& fine = graph.edges();

    std::vector<std::map<int, double>> crossing(size);
    for (int i = 0; i < graph.size(); ++i)
        for (int a = fine.offsets[i]; a < fine.offsets[i + 1]; ++a) {
            const int p = label[i];
            const int q = label[fine.neighbours[a]];
            if (p != q && p >= 0)
                crossing[p][q] += fine.weights[a] * (rest.row(i) - rest.row(fine.neighbours[a])).norm();
        }
    GraphEdges edges;
    for (int p = 0; p < size; ++p) {
        for (const auto& [q, weight] : crossing[p]) {
            const double length = (means.row(p) - means.row(q)).norm();
            edges.neighbours.push_back(q);
            edges.weights.push_back(length > 0 && weight > 0 ? weight / length : 1.0);
        }
        edges.offsets.push_back(static_cast<int>(edges.neighbours.size()));
    }

    GraphHandles handles;
    handles.hard.assign(size, -1);
    handles.idle.assign(size, false);
    for (int i = 0; i < graph.size(); ++i)
        if (label[i] >= 0)
            handles.hard[label[i]] = graph.hard(i);
    std::map<std::pair<int, int>, double> pulls;
    for (const GraphPull& pull : graph.pulls())
        pulls[{label[pull.node], pull.handle}] += pull.stiffness;
    for (const auto& [key, stiffness] : pulls)
        handles.pulls.push_back({key.first, key.second, stiffness});
    return {std::move(edges), std::move(handles)};
}

} // namespace sinew
