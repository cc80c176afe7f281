// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/geodesic_distance.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

namespace sinew {

namespace {

/// A distance counts as shorter from this share on; otherwise rounding could shorten it for ever.
constexpr double least_gain = 1e-12;
/// How often a vertex is reached before the share doubles with every eighth time. Ordinary meshes take up to
/// 4 times. Slivers, of a mesh pressed flat, shorten their distances in ever smaller steps, of which each
/// sets off more: thousands of times, on larger meshes ever more. So none is reached more than 360 times.
constexpr int patience = 30;

/// The least of u(p) + |p - at| over the points p from a to b, with u linear between them.
double through_edge(const Vector3& at, const Vector3& a, double u_a, const Vector3& b, double u_b)
{
    const Vector3 edge = b - a, to = at - a;
    const double length = edge.norm(), slope = (u_b - u_a) / length;
    const double at_ends = std::min(u_a + to.norm(), u_b + (at - b).norm());
    if (!(std::abs(slope) < 1.0)) // also where the edge has no length, or u_b is infinite
        return at_ends;
    const double foot = to.dot(edge) / length,
                 height = std::sqrt(std::max(0.0, to.squaredNorm() - foot * foot));
    const double best = foot - height * slope / std::sqrt(1.0 - slope * slope);
    if (!(best > 0.0 && best < length))
        return at_ends;
    return u_a + slope * best + std::hypot(foot - best, height);
}

} // namespace

GeodesicDistance::GeodesicDistance(const SurfaceMesh& mesh)
    : mesh_(mesh), offsets_(mesh.vertex_count() + 1, 0)
{
    for (const Triangle& t : mesh.triangles())
        for (int v : t)
            ++offsets_[v + 1];
    std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
    triangles_.resize(offsets_.back());
    std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
    for (int t = 0; t < static_cast<int>(mesh.triangles().size()); ++t)
        for (int v : mesh.triangles()[t])
            triangles_[next[v]++] = t;
}

std::vector<double> GeodesicDistance::from(const std::vector<Source>& sources,
                                           std::int64_t* shortenings) const
{
    std::vector<double> found(mesh_.vertex_count(), std::numeric_limits<double>::infinity());
    std::vector<int> times(found.size(), 0);
    using Reached = std::pair<double, int>;
    std::priority_queue<Reached, std::vector<Reached>, std::greater<>> open;
    const auto reach = [&](int vertex, double distance) {
        const double gain = std::ldexp(least_gain, std::max(0, times[vertex] - patience) / 8);
        if (distance < found[vertex] * (1.0 - gain) || std::isinf(found[vertex])) {
            found[vertex] = distance;
            ++times[vertex];
            open.emplace(distance, vertex);
        }
    };
    for (const auto& [vertex, distance] : sources)
        reach(vertex, distance);
    while (!open.empty()) {
        const auto [distance, v] = open.top();
        open.pop();
        if (distance > found[v])
            continue; // reached on a shorter way since
        const Vector3 here = mesh_.point(v);
        for (int at = offsets_[v]; at < offsets_[v + 1]; ++at) {
            const Triangle& t = mesh_.triangles()[triangles_[at]];
            for (int k = 0; k < 3; ++k) {
                const int one = t[k], other = t[(k + 1) % 3], third = t[(k + 2) % 3];
                // Through an edge at v to the corner opposite.
                if (one == v || other == v)
                    reach(third,
                          through_edge(mesh_.point(third), here, distance,
                                       mesh_.point(one == v ? other : one), found[one == v ? other : one]));
            }
        }
    }
    if (shortenings)
        *shortenings = std::accumulate(times.begin(), times.end(), std::int64_t{0});
    return found;
}

} // namespace sinew
