// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/patch_dissection.h"

#include "native/core/parallel.h"
#include "native/solvers/dissection/patches.h"
#include "native/solvers/dissection/vertex_separator.h"
#include "native/solvers/engines/cholmod_factor.h"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <numeric>
#include <span>
#include <utility>

namespace sinew {

namespace {

constexpr int most_in_leaf = 1000;
constexpr int fewest_patches = 8; ///< that are worth halving
constexpr int most_levels = 24;   ///< so that the names of parts are no larger than an int
constexpr int rings = 2;          ///< of the band around the border
constexpr int largest_band = 6;   ///< no further ring where the band is more than a sixth of the part

/// A part has a name, which all of its nodes carry: 1 for the whole, 2 p and 2 p + 1 for the halves of p. Parts of
/// other threads change the names of their nodes at the same time, but never into a name that is asked for here.
class Dissection
{
public:
    explicit Dissection(const Graph& graph)
        : graph_(graph), patches_(patches_of(graph)), part_(graph.size()), place_(graph.size(), -1),
          order_(graph.size())
    {
        std::iota(order_.begin(), order_.end(), 0);
        std::ranges::stable_sort(order_, {}, [&](int v) { return patches_.of[v]; });
        for (const int v : order_)
            move(v, 1);
        dissect(order_, 1);
    }

    std::vector<int> take_order() { return std::move(order_); }

private:
    static constexpr int no_part = 0; ///< the name of separators

    int part(int v) const { return part_[v].load(std::memory_order_relaxed); }
    void move(int v, int name) { part_[v].store(name, std::memory_order_relaxed); }
    int other_half(int v) const { return part(v) ^ 1; }

    /// Puts the nodes of a part, which are sorted by patches, into the order of their elimination.
    void dissect(std::span<int> nodes, int name)
    {
        if (nodes.size() <= most_in_leaf || name >> most_levels)
            return order_leaf(nodes, name);
        std::vector<int> border;
        if (!halve(nodes, name, border)) {
            for (const int v : nodes)
                move(v, name);
            return order_leaf(nodes, name);
        }
        for (const int v : separator(border, name, static_cast<int>(nodes.size())))
            move(v, no_part);
        const auto first_of = [&](std::span<int> all, int half) {
            const auto others = std::ranges::stable_partition(all, [&](int v) { return part(v) == half; });
            return std::span(all.begin(), others.begin());
        };
        const std::span<int> first = first_of(nodes, 2 * name),
                             second = first_of(nodes.subspan(first.size()), 2 * name + 1);
        parallel_tasks(2, [&](int half) { dissect(half == 0 ? first : second, 2 * name + half); });
    }

    /// Gives each node the name of a half, and finds those with neighbours in the other one.
    /// \return false if there is nothing to halve.
    bool halve(std::span<const int> nodes, int name, std::vector<int>& border)
    {
        const auto [touching, counts] = present(nodes);
        if (touching.size() < fewest_patches || touching.neighbours.empty())
            return false;
        std::vector<Side> sides = bisection(touching, counts);
        int size[2] = {0, 0};
        for (int p = 0; p < touching.size(); ++p)
            if (sides[p] != Side::separator)
                size[static_cast<int>(sides[p])] += counts[p];
        std::ranges::replace(sides, Side::separator, size[1] < size[0] ? Side::second : Side::first);
        if (std::ranges::count(sides, sides[0]) == touching.size())
            return false;

        const auto for_each = [&](auto&& visit) {
            const int* v = nodes.data();
            for (int p = 0; p < touching.size(); ++p)
                for (const int* end = v + counts[p]; v < end; ++v)
                    visit(p, *v);
        };
        for_each([&](int p, int v) { move(v, 2 * name + static_cast<int>(sides[p])); });
        std::vector<char> at_border(touching.size(), false);
        for (int p = 0; p < touching.size(); ++p)
            at_border[p] = std::ranges::any_of(touching.of(p), [&](int q) { return sides[q] != sides[p]; });
        for_each([&](int p, int v) {
            if (at_border[p] && is_on_border(v))
                border.push_back(v);
        });
        return true;
    }

    /// The graph of the patches of a part, and how many of its nodes are in each of them.
    std::pair<Graph, std::vector<int>> present(std::span<const int> nodes) const
    {
        std::vector<int> names, counts;
        for (const int v : nodes) {
            if (names.empty() || names.back() != patches_.of[v]) {
                names.push_back(patches_.of[v]);
                counts.push_back(0);
            }
            ++counts.back();
        }
        Graph touching;
        for (const int p : names) {
            auto at = names.begin();
            for (const int q : patches_.touching.of(p)) {
                at = std::lower_bound(at, names.end(), q);
                if (at != names.end() && *at == q)
                    touching.neighbours.push_back(static_cast<int>(at - names.begin()));
            }
            touching.offsets.push_back(static_cast<int>(touching.neighbours.size()));
        }
        return {std::move(touching), std::move(counts)};
    }

    bool is_on_border(int v) const
    {
        return std::ranges::any_of(graph_.of(v), [&](int u) { return part(u) == other_half(v); });
    }

    /// The smallest separator of the halves of a part near their border. Nodes that it moves to the other side of
    /// itself change their halves.
    std::vector<int> separator(const std::vector<int>& border, int name, int nodes)
    {
        std::vector<int> band = border;
        for (int k = 0; k < static_cast<int>(band.size()); ++k)
            place_[band[k]] = k;
        std::size_t begin = 0;
        for (int ring = 0; ring < rings && static_cast<int>(band.size()) < nodes / largest_band; ++ring)
            for (const std::size_t end = band.size(); begin < end; ++begin)
                for (const int u : graph_.of(band[begin]))
                    if (part(u) / 2 == name && place_[u] < 0) {
                        place_[u] = static_cast<int>(band.size());
                        band.push_back(u);
                    }
        const int size = static_cast<int>(band.size());
        Graph within;
        std::vector<char> beside[2]; // whether each node has a neighbour outside the band in each half
        for (std::vector<char>& flags : beside)
            flags.assign(size, false);
        for (int k = 0; k < size; ++k) {
            for (const int u : graph_.of(band[k]))
                if (part(u) / 2 == name) {
                    if (place_[u] >= 0)
                        within.neighbours.push_back(place_[u]);
                    else
                        beside[part(u) % 2][k] = true;
                }
            within.offsets.push_back(static_cast<int>(within.neighbours.size()));
        }
        for (const int v : band)
            place_[v] = -1;

        std::vector<int> found;
        const auto reaches_out = [](const std::vector<char>& flags) {
            return std::ranges::count(flags, true) > 0;
        };
        if (!reaches_out(beside[0]) || !reaches_out(beside[1])) {
            std::ranges::copy_if(border, std::back_inserter(found), [&](int v) { return part(v) % 2 == 0; });
            return found;
        }
        const std::vector<Side> sides = vertex_separator(within, beside[0], beside[1]);
        for (int k = 0; k < size; ++k)
            if (sides[k] == Side::separator)
                found.push_back(band[k]);
            else
                move(band[k], 2 * name + static_cast<int>(sides[k]));
        return found;
    }

    void order_leaf(std::span<int> nodes, int name)
    {
        if (nodes.empty())
            return;
        const std::vector<int> own(nodes.begin(), nodes.end());
        const int count = static_cast<int>(own.size());
        for (int k = 0; k < count; ++k)
            place_[own[k]] = k;
        Graph graph;
        std::vector<std::pair<int, int>> outward; // a node of a separator, and a neighbour of it here
        for (int k = 0; k < count; ++k) {
            for (const int u : graph_.of(own[k]))
                if (part(u) == name)
                    graph.neighbours.push_back(place_[u]);
                else
                    outward.emplace_back(u, k);
            graph.offsets.push_back(static_cast<int>(graph.neighbours.size()));
        }
        for (const int v : own)
            place_[v] = -1;
        std::ranges::sort(outward);
        for (std::size_t k = 0; k < outward.size(); ++k) {
            graph.neighbours.push_back(outward[k].second);
            if (k + 1 == outward.size() || outward[k + 1].first != outward[k].first)
                graph.offsets.push_back(static_cast<int>(graph.neighbours.size()));
        }
        std::vector<int> sets(graph.size(), 1);
        std::fill_n(sets.begin(), count, 0);
        const std::vector<int> order = constrained_minimum_degree(graph, sets);
        std::transform(order.begin(), order.begin() + count, nodes.begin(), [&](int k) { return own[k]; });
    }

    const Graph& graph_;
    const Patches patches_;
    std::vector<std::atomic<int>> part_; ///< the part of each node
    std::vector<int> place_; ///< of a node in a band or leaf, while one is looked at; otherwise -1
    std::vector<int> order_;
};

} // namespace

std::vector<int> patch_dissection(const SparseMatrix& matrix)
{
    const Graph graph = graph_of(matrix);
    return Dissection(graph).take_order();
}

} // namespace sinew
