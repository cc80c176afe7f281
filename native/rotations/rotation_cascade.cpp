// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/rotations/rotation_cascade.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/graph/rotations.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace sinew {

namespace {

constexpr int coarsening = 4;
constexpr int fewest_nodes = 60;
constexpr int most_levels = 8;
constexpr double worthwhile = 0.7;    ///< a level with a larger share of the finer nodes is left out

/// Sets the rotations of the next finer problem from those of a level.
void hand_down(const RotationLevel& level, const std::vector<Eigen::Quaterniond>& rotations,
               GraphProblem& finer)
{
    parallel_for(static_cast<int>(level.map.label().size()), [&](int i) {
        if (level.map.label()[i] >= 0)
            finer.set_rotation(i, handed_down(level.map, rotations, i).toRotationMatrix());
    });
}

void blend_handles(GraphProblem& problem, const RotationGraph& graph, const Poses& poses)
{
    const auto rotations =
        blended_rotations(graph.nodes(), graph.laplacian(), graph.position_factor(), poses);
    for (int i = 0; i < graph.size(); ++i)
        if (!graph.nodes().is_idle(i))
            problem.set_rotation(i, rotations[i].toRotationMatrix());
}

} // namespace

RotationLevel::RotationLevel(const RotationGraph& finer, const Points& finer_rest, const Clusters& clusters)
    : map(finer.nodes(), finer_rest, clusters), graph(graph_of_clusters(finer.nodes(), finer_rest, map),
                                                      {.rigidity = map.restrict(finer.cells().rigidity),
                                                       .smoothing = finer.cells().smoothing,
                                                       .triangles = {}},
                                                      map.restrict(view(finer_rest)))
{
    map.renumber(graph.order());
    rest = map.restrict(view(finer_rest));
}

void GraphGoals::set(const RotationGraph& graph, const Targets& goal)
{
    const HandleGraph& nodes = graph.nodes();
    targets = goal.base();
    pulls.resize(nodes.pulls().size(), 3);
    for (int i = 0; i < nodes.size(); ++i)
        if (nodes.hard(i) >= 0)
            targets.row(i) = goal.position(i, nodes.hard(i)).transpose();
    for (std::size_t k = 0; k < nodes.pulls().size(); ++k)
        pulls.row(k) = goal.position(nodes.pulls()[k].node, nodes.pulls()[k].handle).transpose();
}

RotationCascade::RotationCascade(const RotationGraph& fine, const Points& rest, const Progress& progress)
{
    const RotationGraph* graph = &fine;
    const Points* points = &rest;
    levels_.reserve(most_levels); // so that `graph` may point into it
    // Where no node is free, nothing needs a start.
    while (fine.free_count() > 0 && static_cast<int>(levels_.size()) < most_levels &&
           graph->size() / coarsening >= fewest_nodes) {
        progress.tick(0.6 + 0.4 * levels_.size() / most_levels, "clustering");
        const Clusters clusters(graph->nodes(), *points, graph->size() / coarsening, graph->order());
        const auto active = std::ranges::count_if(clusters.label, [](int p) { return p >= 0; });
        if (clusters.seeds.size() > worthwhile * active)
            break;
        try {
            levels_.emplace_back(*graph, *points, clusters);
        } catch (const OutOfMemory&) {
            throw;
        } catch (const FactorizationFailed&) {
            break; // the finer levels are a start, too
        }
        graph = &levels_.back().graph;
        points = &levels_.back().rest;
    }
}

void RotationCascade::start(GraphProblem& fine_problem, const RotationGraph& fine, const Targets& targets,
                            std::vector<GraphWorkspace>& work) const
{
    if (levels_.empty()) {
        blend_handles(fine_problem, fine, targets.poses);
        return;
    }
    const int count = static_cast<int>(levels_.size());
    work.resize(count);
    if (targets.incoming) // takes its means on every level, from fine to coarse
        for (int l = 0; l < count; ++l)
            levels_[l].map.restrict(l == 0 ? *targets.incoming : view(work[l - 1].base), work[l].base);

    for (int l = count - 1; l >= 0; --l) {
        const RotationGraph& graph = levels_[l].graph;
        Targets local{targets.poses, view(levels_[l].rest), {}, targets.from_rest};
        if (targets.incoming)
            local.incoming.emplace(view(work[l].base));
        GraphGoals& goals = work[l].goals;
        goals.set(graph, local);
        GraphProblem problem(graph, local.base(), goals.targets, goals.pulls, &work[l].buffers);
        if (l + 1 == count)
            blend_handles(problem, graph, targets.poses);
        else
            hand_down(levels_[l + 1], work[l + 1].rotations, problem);
        problem.positions_for_rotations(work[l].x);
        const double scale = targets.incoming ? graph.scale(local.base()) : graph.rest_scale();
        minimize(problem, work[l].x, {.max_iterations = 20, .tolerance = 1e-4, .floor = 1e-14 * scale}, {},
                 &work[l].descent);
        problem.refresh(work[l].x);
        work[l].rotations.resize(graph.size());
        parallel_for(graph.size(),
                     [&](int i) { work[l].rotations[i] = Eigen::Quaterniond(problem.rotation(i)); });
    }
    hand_down(levels_.front(), work.front().rotations, fine_problem);
}

} // namespace sinew
