// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/dissection/vertex_separator.h"

#include <algorithm>

namespace sinew {

namespace {

/// Paths without common nodes, and the search for more of them. A node v is two places, its entrance 2 v and its exit
/// 2 v + 1, between which one path may lead.
class Paths
{
public:
    Paths(const Graph& graph, const std::vector<char>& first, const std::vector<char>& second)
        : graph_(graph), first_(first), second_(second), before_(graph.size(), none),
          used_(graph.size(), false), level_(2 * graph.size()), tried_(2 * graph.size())
    {
        while (measure())
            for (int v = 0; v < graph.size(); ++v)
                if (first[v] && level_[entrance(v)] == 0 && find_path(v))
                    apply();
    }

    /// After the last search: whether a path could still reach the place.
    bool reaches_entrance(int v) const { return level_[entrance(v)] >= 0; }
    bool reaches_exit(int v) const { return level_[exit(v)] >= 0; }

private:
    static constexpr int none = -1;
    static int entrance(int v) { return 2 * v; }
    static int exit(int v) { return 2 * v + 1; }
    static bool is_exit(int place) { return place % 2 == 1; }

    /// Number of places to which a new path can go on from this one; some of them may be none.
    int ways(int place) const
    {
        return is_exit(place) ? static_cast<int>(graph_.of(place / 2).size()) + 1 : 1;
    }

    /// A path that enters a used node can only go back along the path there, which then is led anew.
    int way(int place, int number) const
    {
        const int v = place / 2;
        if (!is_exit(place))
            return !used_[v] ? exit(v) : before_[v] != none ? exit(before_[v]) : none;
        const auto around = graph_.of(v);
        if (number == static_cast<int>(around.size()))
            return used_[v] ? entrance(v) : none;
        return entrance(around[number]);
    }

    /// Number of steps from the first side to each place. \return whether the second side is reached.
    bool measure()
    {
        std::ranges::fill(level_, none);
        queue_.clear();
        for (int v = 0; v < graph_.size(); ++v)
            if (first_[v]) {
                level_[entrance(v)] = 0;
                queue_.push_back(entrance(v));
            }
        bool arrives = false;
        for (std::size_t head = 0; head < queue_.size(); ++head) {
            const int place = queue_[head];
            arrives = arrives || (is_exit(place) && second_[place / 2]);
            for (int k = 0; k < ways(place); ++k)
                if (const int next = way(place, k); next != none && level_[next] == none) {
                    level_[next] = level_[place] + 1;
                    queue_.push_back(next);
                }
        }
        std::ranges::fill(tried_, 0);
        return arrives;
    }

    /// Depth first along rising levels, each way once per phase.
    bool find_path(int start)
    {
        path_.assign(1, entrance(start));
        while (!path_.empty()) {
            const int place = path_.back();
            if (is_exit(place) && second_[place / 2])
                return true;
            int next = none;
            for (; next == none && tried_[place] < ways(place); ++tried_[place])
                if (const int w = way(place, tried_[place]); w != none && level_[w] == level_[place] + 1)
                    next = w;
            if (next != none) {
                path_.push_back(next);
            } else {
                level_[place] = dead;
                path_.pop_back();
            }
        }
        return false;
    }

    void apply()
    {
        for (std::size_t k = 0; k + 1 < path_.size(); ++k)
            if (const int from = path_[k], to = path_[k + 1]; !is_exit(from) && from / 2 != to / 2)
                before_[from / 2] = none;
        for (std::size_t k = 0; k + 1 < path_.size(); ++k) {
            const int from = path_[k], to = path_[k + 1];
            if (from / 2 == to / 2)
                used_[from / 2] = !is_exit(from);
            else if (is_exit(from))
                before_[to / 2] = from / 2;
        }
        for (const int place : path_)
            level_[place] = dead;
    }

    static constexpr int dead = -2; ///< the level of a place that no path of this phase can use

    const Graph& graph_;
    const std::vector<char>&first_, &second_;
    std::vector<int> before_; ///< the node before each one on its path, or none
    std::vector<char> used_;  ///< whether a path leads through each node
    std::vector<int> level_, tried_, queue_, path_;
};

} // namespace

std::vector<Side> vertex_separator(const Graph& graph, const std::vector<char>& first,
                                   const std::vector<char>& second)
{
    const Paths paths(graph, first, second);
    std::vector<Side> sides(graph.size());
    for (int v = 0; v < graph.size(); ++v)
        sides[v] = paths.reaches_exit(v)       ? Side::first
                   : paths.reaches_entrance(v) ? Side::separator
                                               : Side::second;
    return sides;
}

} // namespace sinew
