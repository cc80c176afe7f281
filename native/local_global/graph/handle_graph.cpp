// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/graph/handle_graph.h"

#include <algorithm>
#include <utility>

namespace sinew {

GraphHandles::GraphHandles(const Regions& regions, const std::function<double(int)>& diagonal)
    : hard(regions.vertex_count()), idle(regions.vertex_count())
{
    for (int i = 0; i < regions.vertex_count(); ++i) {
        hard[i] = regions.hard(i);
        idle[i] = regions.is_idle(i);
    }
    for (const SoftConstraint& s : regions.soft()) {
        const double unit = diagonal(s.vertex);
        pulls.push_back({s.vertex, s.handle, s.stiffness() * (unit > 0 ? unit : 1.0)});
    }
}

HandleGraph::HandleGraph(GraphEdges edges, GraphHandles handles)
    : edges_(std::move(edges)), handles_(std::move(handles)), place_(edges_.size(), -1)
{
    for (int i = 0; i < size(); ++i)
        if (hard(i) < 0 && !is_idle(i)) {
            place_[i] = free_count();
            free_nodes_.push_back(i);
        }
}

HandleGraph HandleGraph::renumbered(const std::vector<int>& old) const
{
    const std::vector<int> renamed = new_numbers(old);
    GraphEdges edges;
    GraphHandles handles;
    for (int i : old) {
        std::vector<std::pair<int, double>> own;
        for (int a = edges_.offsets[i]; a < edges_.offsets[i + 1]; ++a)
            own.emplace_back(renamed[edges_.neighbours[a]], edges_.weights[a]);
        std::ranges::sort(own);
        for (const auto& [j, weight] : own) {
            edges.neighbours.push_back(j);
            edges.weights.push_back(weight);
        }
        edges.offsets.push_back(static_cast<int>(edges.neighbours.size()));
        handles.hard.push_back(hard(i));
        handles.idle.push_back(is_idle(i));
    }
    handles.pulls = pulls();
    for (GraphPull& pull : handles.pulls)
        pull.node = renamed[pull.node];
    return {std::move(edges), std::move(handles)};
}

std::vector<int> new_numbers(const std::vector<int>& old)
{
    std::vector<int> renamed(old.size());
    for (std::size_t i = 0; i < old.size(); ++i)
        renamed[old[i]] = static_cast<int>(i);
    return renamed;
}

} // namespace sinew
