// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/supernodal/tree.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace sinew {

template <class T>
SupernodalTree::SupernodalTree(const BasicSupernodalFactor<T>& f) : owner(f.size), parent(f.supernodes, -1)
{
    for (int s = 0; s < f.supernodes; ++s)
        std::fill(owner.begin() + f.first[s], owner.begin() + f.first[s + 1], s);
    for (int s = 0; s < f.supernodes; ++s)
        if (f.height(s) > f.columns(s))
            parent[s] = owner[f.rows_of(s)[f.columns(s)]];
}

template SupernodalTree::SupernodalTree(const BasicSupernodalFactor<double>&);
template SupernodalTree::SupernodalTree(const BasicSupernodalFactor<float>&);

SupernodalSplit split(const SupernodalTree& tree, std::vector<double> weights, int count)
{
    const int supernodes = static_cast<int>(tree.parent.size());
    SupernodalSplit result;
    result.on_top.assign(supernodes, false);
    const double most = std::accumulate(weights.begin(), weights.end(), 0.0) / count;
    std::vector<int> start(supernodes), chosen;
    std::vector<std::vector<int>> children(supernodes);
    std::iota(start.begin(), start.end(), 0);
    for (int s = 0; s < supernodes; ++s) { // children come before their parents
        const int above = tree.parent[s];
        if (above < 0) {
            chosen.push_back(s);
            continue;
        }
        weights[above] += weights[s];
        start[above] = std::min(start[above], start[s]);
        children[above].push_back(s);
    }

    const auto lighter = [&](int a, int b) { return std::pair(weights[a], a) < std::pair(weights[b], b); };
    std::make_heap(chosen.begin(), chosen.end(), lighter);
    while (!chosen.empty() && weights[chosen.front()] > most) {
        const int heaviest = chosen.front();
        std::pop_heap(chosen.begin(), chosen.end(), lighter);
        chosen.pop_back();
        result.on_top[heaviest] = true;
        for (const int child : children[heaviest]) {
            chosen.push_back(child);
            std::push_heap(chosen.begin(), chosen.end(), lighter);
        }
    }
    std::sort(chosen.begin(), chosen.end());
    // Neighbouring subtrees are joined until each part has its share of the weight.
    double gathered = 0;
    for (const int root : chosen) {
        const bool adjoins = !result.parts.empty() && result.parts.back().end == start[root];
        if (!adjoins || gathered + weights[root] > most) {
            result.parts.push_back({start[root], start[root]});
            gathered = 0;
        }
        result.parts.back().end = root + 1;
        gathered += weights[root];
    }
    return result;
}

} // namespace sinew
