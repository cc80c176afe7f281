// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/edge_distances.h"

#include <algorithm>
#include <array>
#include <functional>
#include <queue>
#include <utility>

namespace sinew {

EdgeDistances::EdgeDistances(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles)
{
    std::vector<std::array<int, 2>> directed;
    directed.reserve(6 * triangles.size());
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) {
            directed.push_back({t[k], t[(k + 1) % 3]});
            directed.push_back({t[(k + 1) % 3], t[k]});
        }
    std::ranges::sort(directed);
    directed.erase(std::ranges::unique(directed).begin(), directed.end());
    offsets_.assign(points.size() + 1, 0);
    for (const auto& [a, b] : directed) {
        ++offsets_[a + 1];
        neighbours_.push_back(b);
        lengths_.push_back((points[a] - points[b]).norm());
    }
    for (std::size_t v = 0; v < points.size(); ++v)
        offsets_[v + 1] += offsets_[v];
}

std::vector<double> EdgeDistances::from(int vertex, double most) const
{
    std::vector<double> found(offsets_.size() - 1, std::numeric_limits<double>::infinity());
    using Reached = std::pair<double, int>;
    std::priority_queue<Reached, std::vector<Reached>, std::greater<>> open;
    found[vertex] = 0.0;
    open.emplace(0.0, vertex);
    while (!open.empty()) {
        const auto [distance, v] = open.top();
        open.pop();
        if (distance > found[v])
            continue; // reached on a shorter way since
        for (int e = offsets_[v]; e < offsets_[v + 1]; ++e)
            if (const double next = distance + lengths_[e]; next < found[neighbours_[e]] && next <= most) {
                found[neighbours_[e]] = next;
                open.emplace(next, neighbours_[e]);
            }
    }
    return found;
}

} // namespace sinew
