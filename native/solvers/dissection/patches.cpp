// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/dissection/patches.h"

#include <algorithm>
#include <numeric>

namespace sinew {

namespace {

constexpr int fewest_around = 50; ///< nodes around a seed; half of them stay its own

std::vector<int> seeds_of(const Graph& graph)
{
    const int n = graph.size();
    std::vector<int> seeds, ball, seen_by(n, -1);
    for (int v = 0; v < n; ++v) {
        if (seen_by[v] >= 0)
            continue;
        seeds.push_back(v);
        ball.assign(1, v);
        seen_by[v] = v;
        for (std::size_t begin = 0; begin < ball.size() && ball.size() < fewest_around;)
            for (const std::size_t end = ball.size(); begin < end; ++begin)
                for (const int u : graph.of(ball[begin]))
                    if (seen_by[u] != v) {
                        seen_by[u] = v;
                        ball.push_back(u);
                    }
    }
    return seeds;
}

} // namespace

Patches patches_of(const Graph& graph)
{
    const int n = graph.size();
    std::vector<int> queue = seeds_of(graph);
    const int count = static_cast<int>(queue.size());
    Patches patches{.of = std::vector<int>(n, -1), .touching = {}};
    for (int p = 0; p < count; ++p)
        patches.of[queue[p]] = p;
    queue.reserve(n);
    for (std::size_t head = 0; head < queue.size(); ++head)
        for (const int u : graph.of(queue[head]))
            if (patches.of[u] < 0) {
                patches.of[u] = patches.of[queue[head]];
                queue.push_back(u);
            }

    std::vector<int> begin(count + 1, 0), members(n), seen_by(count, -1);
    for (const int p : patches.of)
        ++begin[p + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<int> next(begin.begin(), begin.end() - 1);
    for (int v = 0; v < n; ++v)
        members[next[patches.of[v]]++] = v;
    Graph& touching = patches.touching;
    for (int p = 0; p < count; ++p) {
        seen_by[p] = p;
        for (int at = begin[p]; at < begin[p + 1]; ++at)
            for (const int u : graph.of(members[at]))
                if (const int q = patches.of[u]; seen_by[q] != p) {
                    seen_by[q] = p;
                    touching.neighbours.push_back(q);
                }
        std::sort(touching.neighbours.begin() + touching.offsets[p], touching.neighbours.end());
        touching.offsets.push_back(static_cast<int>(touching.neighbours.size()));
    }
    return patches;
}

} // namespace sinew
