// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/frames/feet.h"

#include "native/core/parallel.h"

#include <algorithm>
#include <array>
#include <unordered_set>
#include <utility>

namespace sinew {

namespace {

constexpr int most_looks = 400; ///< triangles on the way between two feet
constexpr int rise = 8;         ///< edges from a tear to a share that nothing limits

/// Whether the host joins two of its triangles by triangles whose centres are within `reach` of a place.
bool are_joined(const HostSurface& host, int from, int to, const Vector3& place, double reach)
{
    std::vector<int> open{from};
    std::unordered_set<int> seen{from};
    for (std::size_t next = 0; next < open.size() && next < most_looks; ++next) {
        if (open[next] == to)
            return true;
        for (int v : host.triangles()[open[next]])
            for (int t : host.around(v))
                if ((t == to || (host.centres()[t] - place).norm() <= reach) && seen.insert(t).second)
                    open.push_back(t);
    }
    return false;
}

} // namespace

std::vector<Foot> feet_of(const Part& part, const HostSurface& host, const FrameLayout& layout,
                          const VectorX& trusted)
{
    const int count = static_cast<int>(part.points.size());
    std::vector<TriangleTree::Place> beneath(part.points.size());
    std::vector<double> gaps(part.points.size()), shares(part.points.size());
    const Eigen::RowVectorXd followed = trusted.transpose() * layout.shares;
    parallel_for(
        count,
        [&](int v) {
            beneath[v] = host.tree().closest_place(part.points[v]);
            gaps[v] = (part.points[v] - beneath[v].point).norm();
            shares[v] = layout.bending * std::min(1.0, followed[v]);
        },
        64);
    std::vector<std::array<int, 2>> edges;
    for (const Triangle& t : part.triangles)
        for (int k = 0; k < 3; ++k)
            edges.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    std::ranges::sort(edges);
    edges.erase(std::ranges::unique(edges).begin(), edges.end());
    std::vector<char> torn(edges.size(), 0);
    parallel_for(
        static_cast<int>(edges.size()),
        [&](int e) {
            const auto& [a, b] = edges[e];
            const double reach =
                2.0 * (part.points[a] - part.points[b]).norm() + gaps[a] + gaps[b] + 2.0 * host.spacing();
            torn[e] = shares[a] > 0.0 && shares[b] > 0.0 &&
                      !are_joined(host, beneath[a].triangle, beneath[b].triangle, beneath[a].point, reach);
        },
        64);
    if (std::ranges::count(torn, 1) > 0) {
        std::vector<double> limits(part.points.size(), 1.0);
        for (std::size_t e = 0; e < edges.size(); ++e)
            if (torn[e])
                limits[edges[e][0]] = limits[edges[e][1]] = 0.0;
        for (int round = 0; round < rise; ++round)
            for (const auto& [a, b] : edges) {
                limits[a] = std::min(limits[a], limits[b] + 1.0 / rise);
                limits[b] = std::min(limits[b], limits[a] + 1.0 / rise);
            }
        for (int v = 0; v < count; ++v)
            shares[v] *= limits[v];
    }
    const bool has_images = !layout.images.empty();
    std::vector<Foot> feet((has_images ? 2 : 1) * part.points.size());
    const auto foot_at = [&](const TriangleTree::Place& place, double share) {
        const Triangle& corners = host.triangles()[place.triangle];
        const Vector3 parts = barycentric(corners_of(host.part().points, corners), place.point);
        return Foot{corners, {parts[0], parts[1], parts[2]}, share};
    };
    parallel_for(
        count,
        [&](int v) {
            feet[v] = foot_at(beneath[v], has_images ? shares[v] / 2 : shares[v]);
            if (!has_images)
                return;
            const Triangle& there = part.triangles[layout.images[v].triangle];
            const Vector3 parts = barycentric(corners_of(part.points, there), layout.images[v].point);
            const double share =
                parts[0] * shares[there[0]] + parts[1] * shares[there[1]] + parts[2] * shares[there[2]];
            // Where the image is a vertex, its own foot counts: what is on the plane has two that are equally
            // close.
            const auto most = std::ranges::max_element(parts) - parts.begin();
            Foot& image = feet[count + v] = foot_at(
                parts[most] > 1.0 - 1e-6 ? beneath[there[most]]
                                         : host.tree().closest_place(host.mirror_image(part.points[v])),
                share / 2);
            image.corners = host.mirror_image(image.corners); // turned round
            std::swap(image.parts[1], image.parts[2]);
        },
        64);
    return feet;
}

} // namespace sinew
