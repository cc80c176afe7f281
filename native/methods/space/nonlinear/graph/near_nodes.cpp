// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/graph/near_nodes.h"

#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/mesh/frames/surface_frame.h"
#include "native/methods/space/nonlinear/graph/surface_fronts.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace sinew {

namespace {

constexpr float infinite = SurfaceFronts::infinite;
/// A part is measured along its surface if it is farther across than this many spacings of nodes.
constexpr double large_part = 2.5;
constexpr int kept = NearNodes::count + 1;
constexpr int batch = 64; ///< nodes whose fronts run at once
/// The sum of two distances is at most this much shorter than that of a front over both ways.
constexpr float detour = 1.05F;
/// Places are equally far if their distances differ by this share: rounding of the shape in single precision
/// moves fronts by up to 1e-4 along the lines of a grid.
constexpr float tie = 1e-3F;
/// The same for distances from the centre, which are straight.
constexpr float straight_tie = 1e-5F;
/// Nodes that are nearer than the fifth by less than this share count as being as far.
constexpr double least_nearer = 0.01;

double area_of(const SurfaceMesh& mesh)
{
    double sum = 0.0;
    for (const auto& [a, b, c] : mesh.triangles())
        sum += 0.5 * (mesh.point(b) - mesh.point(a)).cross(mesh.point(c) - mesh.point(a)).norm();
    return sum;
}

float largest(const std::vector<float>& numbers)
{
    return Eigen::Map<const Eigen::VectorXf>(numbers.data(), static_cast<Eigen::Index>(numbers.size()))
        .maxCoeff();
}

/// Of the places that are as far as any, the one farthest from the centre, and of those that are equally far
/// from that, the first. So lengths decide where they can; neither the axes nor the last bits of the shape
/// do.
int first_of_farthest(const std::vector<float>& distances, const std::vector<float>& from_centre)
{
    const float least = largest(distances) * (1.0F - tie);
    float outermost = 0.0F;
    for (std::size_t v = 0; v < distances.size(); ++v)
        if (distances[v] >= least)
            outermost = std::max(outermost, from_centre[v]);
    outermost *= 1.0F - straight_tie;
    int first = 0;
    while (distances[first] < least || from_centre[first] < outermost)
        ++first;
    return first;
}

} // namespace

NearNodes::NearNodes(const SurfaceMesh& mesh, int wanted, const Progress& progress)
    : mesh_(mesh), parts_(connected_components(mesh)), large_(static_cast<std::size_t>(parts_.count), 0)
{
    const double spacing = std::sqrt(area_of(mesh) / wanted);
    std::vector<Vector3> middles(static_cast<std::size_t>(parts_.count), Vector3::Zero());
    std::vector<double> counts(middles.size(), 0.0), widths(middles.size(), 0.0);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        middles[part(v)] += mesh.point(v);
        counts[part(v)] += 1.0;
    }
    for (int v = 0; v < mesh.vertex_count(); ++v)
        widths[part(v)] =
            std::max(widths[part(v)], 2.0 * (mesh.point(v) - middles[part(v)] / counts[part(v)]).norm());
    for (const Triangle& triangle : mesh.triangles())
        large_[part(triangle[0])] = widths[part(triangle[0])] > large_part * spacing;
    loose_.assign(static_cast<std::size_t>(mesh.vertex_count()), std::ranges::count(large_, 1) > 0);
    for (const Triangle& triangle : mesh.triangles())
        for (const int v : triangle)
            loose_[v] = 0;
    const SurfaceFronts fronts(mesh);
    find_near(fronts, choose(fronts, wanted, progress), progress);
}

NearNodes::Nearest NearNodes::choose(const SurfaceFronts& fronts, int wanted, const Progress& progress)
{
    SurfaceFronts::Front front(fronts);
    const int n = mesh_.vertex_count();
    Nearest nearest{std::vector<float>(static_cast<std::size_t>(n), infinite),
                    std::vector<int>(static_cast<std::size_t>(n), -1)};
    std::vector<float>& near = nearest.distance;
    std::vector<int> loose;
    std::vector<char> begun(large_.begin(), large_.end()); // 1 for a large part without a node
    auto unreached = std::ranges::count(large_, 1);
    // Begins at the far end of a large part, so that no small one gets a node for nothing.
    const Vector3 centre = surface_frame(mesh_).centre;
    std::vector<float> from_centre, beginnings(near.size(), -1.0F);
    for (int v = 0; v < n; ++v) {
        from_centre.push_back(static_cast<float>((mesh_.point(v) - centre).norm()));
        if (is_loose(v))
            near[v] = 0.0F; // it has no node, and needs none
        else if (!is_on_surface(v))
            loose.push_back(v);
        if (is_on_surface(v) || unreached == 0)
            beginnings[v] = from_centre[v];
    }
    int next = first_of_farthest(beginnings, from_centre);
    while (true) {
        if (nodes_.size() % 64 == 0)
            progress.tick(0.4 * std::min(1.0, static_cast<double>(nodes_.size()) / wanted), "placing nodes");
        nodes_.push_back(next);
        const Vector3 at = mesh_.point(next);
        if (is_on_surface(next)) {
            unreached -= begun[part(next)];
            begun[part(next)] = 0;
            front.from(
                next, [&](int v) { return near[v] + fronts.margin(v); },
                [&](int v, float distance) {
                    if (distance < near[v]) {
                        near[v] = distance;
                        nearest.node[v] = next;
                    }
                });
        }
        near[next] = 0.0F;
        parallel_for(static_cast<int>(loose.size()), [&](int k) {
            near[loose[k]] =
                std::min(near[loose[k]], static_cast<float>((mesh_.point(loose[k]) - at).norm()));
        });
        radius_ = largest(near);
        next = first_of_farthest(near, from_centre);
        if (!(radius_ > 0.0) || (unreached == 0 && static_cast<int>(nodes_.size()) >= wanted))
            break;
    }
    // Of two nodes far apart, the last bits may say which comes first.
    std::ranges::sort(nodes_);
    std::vector<int> number(static_cast<std::size_t>(n), -1);
    for (std::size_t j = 0; j < nodes_.size(); ++j)
        number[nodes_[j]] = static_cast<int>(j);
    for (int& node : nearest.node)
        node = node < 0 ? -1 : number[node];
    return nearest;
}

std::vector<float> NearNodes::to_fourth(const Nearest& nearest) const
{
    std::vector<std::vector<Near>> others(nodes_.size());
    const auto note = [&](int from, int to, float distance) {
        for (Near& near : others[from])
            if (near.second == to) {
                near.first = std::min(near.first, distance);
                return;
            }
        others[from].emplace_back(distance, to);
    };
    for (const Triangle& triangle : mesh_.triangles())
        for (int k = 0; k < 3; ++k) {
            const int a = triangle[k], b = triangle[(k + 1) % 3], from = nearest.node[a],
                      to = nearest.node[b];
            if (from == to || from < 0 || to < 0)
                continue;
            const float distance = nearest.distance[a] + nearest.distance[b] +
                                   static_cast<float>((mesh_.point(a) - mesh_.point(b)).norm());
            note(from, to, distance);
            note(to, from, distance);
        }
    std::vector<float> result;
    for (std::vector<Near>& own : others) {
        std::ranges::sort(own);
        result.push_back(own.size() < count ? infinite : own[count - 1].first);
    }
    return result;
}

void NearNodes::find_near(const SurfaceFronts& fronts, const Nearest& nearest, const Progress& progress)
{
    const int n = mesh_.vertex_count();
    const float farthest = radius_ > 0.0 ? reach * static_cast<float>(radius_) : infinite;
    near_.assign(static_cast<std::size_t>(n) * kept, {farthest, -1});
    const auto put = [&](int v, float distance, int node) {
        Near* const own = near_.data() + static_cast<std::size_t>(v) * kept;
        int k = kept - 1;
        if (!(distance < own[k].first))
            return;
        for (; k > 0 && distance < own[k - 1].first; --k)
            own[k] = own[k - 1];
        own[k] = {distance, node};
    };
    // The nearest node and the four nearest to that one are five, so that no node behind them counts; nor
    // does one behind five that were found in the batches before.
    const std::vector<float> fourth = to_fourth(nearest);
    std::vector<float> bounds(static_cast<std::size_t>(n), infinite);
    for (int v = 0; v < n; ++v)
        if (nearest.node[v] >= 0)
            bounds[v] = std::min(farthest, detour * (nearest.distance[v] + fourth[nearest.node[v]]));
    std::vector<int> number(static_cast<std::size_t>(n), -1);
    for (std::size_t j = 0; j < nodes_.size(); ++j)
        number[nodes_[j]] = static_cast<int>(j);
    std::vector<std::vector<Near>> others(nodes_.size()); // of each node, those around it
    const auto bound = [&](int v) {
        return std::min(bounds[v], near_[static_cast<std::size_t>(v) * kept + kept - 1].first) +
               fronts.margin(v);
    };
    Pool<SurfaceFronts::Front> pool;
    std::vector<std::vector<std::pair<int, float>>> reached(batch);
    for (int first = 0; first < static_cast<int>(nodes_.size()); first += batch) {
        progress.tick(0.4 + 0.3 * first / static_cast<double>(nodes_.size()), "measuring distances");
        const int some = std::min(batch, static_cast<int>(nodes_.size()) - first);
        parallel_chunks(some, 4, [&](int begin, int end) {
            const auto own = pool.take([&] { return std::make_unique<SurfaceFronts::Front>(fronts); });
            for (int k = begin; k < end; ++k) {
                reached[k].clear();
                if (is_on_surface(nodes_[first + k]))
                    own->from(nodes_[first + k], bound,
                              [&](int v, float distance) { reached[k].emplace_back(v, distance); });
            }
        });
        for (int k = 0; k < some; ++k)
            for (const auto& [v, distance] : reached[k]) {
                put(v, distance, first + k);
                if (number[v] >= 0 && v != nodes_[first + k])
                    others[number[v]].emplace_back(distance, first + k);
            }
    }
    parallel_for(
        n,
        [&](int v) {
            if (!is_on_surface(v))
                for (int j = 0; j < static_cast<int>(nodes_.size()); ++j)
                    put(v, static_cast<float>((mesh_.point(nodes_[j]) - mesh_.point(v)).norm()), j);
        },
        64);
    for (int i = 0; i < static_cast<int>(nodes_.size()); ++i) {
        std::vector<Near>& own = others[i];
        if (!is_on_surface(nodes_[i]))
            for (int j = 0; j < static_cast<int>(nodes_.size()); ++j)
                if (j != i)
                    own.emplace_back(
                        static_cast<float>((mesh_.point(nodes_[j]) - mesh_.point(nodes_[i])).norm()), j);
        if (own.empty())
            continue;
        const auto fourth = own.begin() + std::min<std::ptrdiff_t>(count, std::ssize(own)) - 1;
        std::ranges::nth_element(own, fourth);
        const float far = fourth->first * (1.0F + tie);
        for (const auto& [distance, j] : own)
            if (distance <= far)
                pairs_.push_back({std::min(i, j), std::max(i, j)});
        own = {};
    }
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
        if (falling > least_nearer) {
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
        all.emplace_back(static_cast<float>((mesh_.point(nodes_[j]) - place).norm()), j);
    const int found = std::min(kept, static_cast<int>(all.size()));
    std::partial_sort(all.begin(), all.begin() + found, all.end());
    std::array<Near, kept> near;
    near.fill(
        {radius_ > 0.0 ? std::max(reach * static_cast<float>(radius_), 2.0F * all[0].first) : infinite, -1});
    std::copy(all.begin(), all.begin() + found, near.begin());
    return weighed(near.data(), found);
}

} // namespace sinew
