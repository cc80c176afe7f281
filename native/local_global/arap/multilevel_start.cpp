// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/multilevel_start.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/core/progress_part.h"
#include "native/local_global/graph/rotations.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <numeric>

namespace sinew {

namespace {

constexpr int coarsening = 8;
constexpr int fewest_nodes = 60;
constexpr int most_levels = 8;
/// Clusters of motions: one of so many nodes, within bounds. More hardly move better, and their factor costs more.
constexpr int nodes_per_cluster = 60, fewest_clusters = 30, most_clusters = 600;
constexpr int coarsest_iterations = 30, level_iterations = 5;
constexpr int large = 2000, large_iterations = 2; ///< on a level of more than `large` nodes
constexpr double rounding_floor = 1e-14; ///< of sum w |p_i - p_j|^2: an energy below it is rounding
constexpr double worthwhile = 0.7;    ///< a level with a larger share of the finer nodes is left out

/// Sets the rotations of the next finer problem from those of a level.
void hand_down(const RotationLevel& level, const std::vector<Eigen::Quaterniond>& rotations,
               ArapProblem& finer)
{
    parallel_for(static_cast<int>(level.map.label().size()), [&](int i) {
        if (level.map.label()[i] >= 0)
            finer.set_rotation(i, handed_down(level.map, rotations, i).toRotationMatrix());
    });
}

double energy_floor(const ArapSystem& graph, const Targets& targets)
{
    return rounding_floor * (targets.incoming ? graph.scale(targets.base()) : graph.rest_scale());
}

void blend_handles(ArapProblem& problem, const ArapSystem& graph, const Poses& poses)
{
    const auto rotations =
        blended_rotations(graph.nodes(), graph.laplacian(), graph.position_factor(), poses);
    for (int i = 0; i < graph.size(); ++i)
        if (!graph.nodes().is_idle(i))
            problem.set_rotation(i, rotations[i].toRotationMatrix());
}

/// Clusters of the nodes of one graph, the free ones first.
struct MotionClusters
{
    ClusterMap map;
    HandleGraph graph;

    MotionClusters(const HandleGraph& nodes, const Points& points, int wanted)
        : map(nodes, Clusters(nodes, points, wanted)), graph(graph_of_clusters(nodes, points, map))
    {
        std::vector<int> order = graph.free_nodes();
        for (int p = 0; p < graph.size(); ++p)
            if (graph.place(p) < 0)
                order.push_back(p);
        map.renumber(order);
        graph = graph.renumbered(order);
    }
};

} // namespace

RotationLevel::RotationLevel(const HandleGraph& finer, const GraphCells& cells, const Points& finer_rest,
                             const Clusters& clusters, const Progress& progress)
    : map(finer, clusters, progress),
      graph(graph_of_clusters(finer, finer_rest, map),
            {.rigidity = map.restrict(cells.rigidity), .smoothing = cells.smoothing, .triangles = {}},
            map.restrict(view(finer_rest)))
{
    map.renumber(graph.order());
    rest = map.restrict(view(finer_rest));
}

std::optional<RotationLevel> RotationLevel::coarser(const HandleGraph& finer, const GraphCells& cells,
                                                    const Points& finer_rest, const Progress& progress)
{
    int active = 0; // loose vertices and parts without a handle count nothing
    for (int i = 0; i < finer.size(); ++i)
        active += finer.is_idle(i) ? 0 : 1;
    if (active / coarsening < fewest_nodes)
        return {};
    const Clusters clusters(finer, finer_rest, active / coarsening, progress);
    if (clusters.seeds.size() > worthwhile * active)
        return {};
    try {
        return RotationLevel(finer, cells, finer_rest, clusters, progress);
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed&) {
        return {}; // the finer levels are a start, too
    }
}

void GraphGoals::set(const ArapSystem& graph, const Targets& goal)
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

MultilevelStart::MultilevelStart(const ArapSystem& fine, const Points& rest, const Progress& progress)
{
    const ArapSystem* graph = &fine;
    const Points* points = &rest;
    levels_.reserve(most_levels); // so that `graph` may point into it
    // Where no node is free, nothing needs a start.
    while (fine.free_count() > 0 && static_cast<int>(levels_.size()) < most_levels) {
        const double share = 0.6 + 0.4 * levels_.size() / most_levels;
        auto level =
            RotationLevel::coarser(graph->nodes(), graph->cells(), *points, part_of(progress, share, share));
        if (!level)
            break;
        levels_.push_back(std::move(*level));
        graph = &levels_.back().graph;
        points = &levels_.back().rest;
    }
    add_motions(fine, rest);
}

/// Adds the motions of each graph but a coarsest one with few nodes, or without a finer one. Their clusters are the
/// nodes of the next coarser graph, or of one further down that has about as many as are wanted; or they are made
/// of the coarsest graph that has more.
void MultilevelStart::add_motions(const ArapSystem& fine, const Points& rest)
{
    const auto graph = [&](std::size_t g) -> const ArapSystem& {
        return g == 0 ? fine : levels_[g - 1].graph;
    };
    const auto points = [&](std::size_t g) -> const Points& { return g == 0 ? rest : levels_[g - 1].rest; };
    motions_.resize(levels_.size() + 1);
    const int wanted =
        std::clamp(fine.chunks().present() / nodes_per_cluster, fewest_clusters, most_clusters);
    std::optional<MotionClusters> made;
    const HandleGraph* last = nullptr; // the clusters of the next coarser graph
    for (std::size_t g = levels_.size() + 1; g-- > 0;) {
        std::size_t at = g;
        if (g == levels_.size() && (g == 0 || graph(g).size() <= 2 * wanted))
            continue;
        std::vector<int> label(graph(g).size()); // the node of graph `at` that each node of graph g is in
        std::iota(label.begin(), label.end(), 0);
        const auto hand_on = [&](const ClusterMap& map) {
            for (int& p : label)
                p = p < 0 ? p : map.label()[p];
        };
        for (; at < levels_.size() && graph(at + 1).size() > 2 * wanted; ++at)
            hand_on(levels_[at].map);
        const bool found = at < levels_.size() && (at == g || graph(at + 1).size() > wanted / 2);
        if (!found && !made)
            made.emplace(graph(at).nodes(), points(at), wanted);
        hand_on(found ? levels_[at].map : made->map);
        const HandleGraph& clusters = found ? graph(at + 1).nodes() : made->graph;
        try {
            motions_[g] = ClusterMotions(graph(g), points(g), std::move(label), clusters,
                                         &clusters == last ? motions_[g + 1].metric() : nullptr);
        } catch (const OutOfMemory&) {
            throw;
        } catch (const FactorizationFailed&) {
            motions_[g] = {}; // steps in the metric of the Laplacian find the minimum, too
        }
        last = &clusters;
    }
}

std::int64_t MultilevelStart::factor_bytes() const
{
    std::int64_t bytes = 0;
    for (const RotationLevel& level : levels_)
        bytes += level.graph.factor_bytes();
    const SingleFactor* last = nullptr; // a graph and the next coarser one may share theirs
    for (const ClusterMotions& motions : motions_)
        if (const SingleFactor* metric = motions.metric().get(); metric && metric != last) {
            bytes += metric->bytes();
            last = metric;
        }
    return bytes;
}

CascadeSolve::CascadeSolve(const MultilevelStart& cascade, ArapProblem& fine_problem, const ArapSystem& fine,
                           const Targets& targets, std::vector<GraphWorkspace>& work)
    : cascade_(cascade), fine_problem_(fine_problem), fine_(fine), targets_(targets), work_(work)
{
    const std::vector<RotationLevel>& levels = cascade.levels();
    const int count = static_cast<int>(levels.size());
    work.resize(count);
    problems_.reserve(count);
    fine_problem.improve_by(cascade.motions(0));
    for (int l = 0; l < count; ++l) {
        const ArapSystem& graph = levels[l].graph;
        Targets local{targets.poses, view(levels[l].rest), {}, targets.from_rest};
        if (targets.incoming) {
            levels[l].map.restrict(l == 0 ? *targets.incoming : view(work[l - 1].base), work[l].base);
            local.incoming.emplace(view(work[l].base));
        }
        work[l].goals.set(graph, local);
        problems_.emplace_back(graph, local.base(), work[l].goals.targets, work[l].goals.pulls,
                               &work[l].buffers);
        floors_.push_back(energy_floor(graph, local));
        problems_.back().improve_by(cascade.motions(l + 1));
    }
}

void CascadeSolve::start()
{
    const std::vector<RotationLevel>& levels = cascade_.levels();
    const int count = static_cast<int>(levels.size());
    if (count == 0) {
        blend_handles(fine_problem_, fine_, targets_.poses);
        return;
    }
    blend_handles(problems_.back(), levels.back().graph, targets_.poses);
    for (int l = count - 1; l >= 0; --l)
        hand_down(levels[l], descend(l + 1, problems_[l], work_[l], floors_[l]),
                  l == 0 ? fine_problem_ : problems_[l - 1]);
}

const std::vector<Eigen::Quaterniond>& CascadeSolve::solve(GraphWorkspace& work)
{
    start();
    return descend(0, fine_problem_, work, energy_floor(fine_, targets_));
}

/// Iterations on one problem, from its rotations.
/// \param level  0 for the fine problem, which comes before the levels of the cascade.
const std::vector<Eigen::Quaterniond>& CascadeSolve::descend(int level, ArapProblem& problem,
                                                             GraphWorkspace& work, double floor)
{
    const bool coarsest = level == static_cast<int>(cascade_.levels().size());
    problem.global_step(work.x);
    const int iterations = problem.free_count() > large ? large_iterations : level_iterations;
    minimize(
        problem, work.x,
        {.max_iterations = coarsest ? coarsest_iterations : iterations, .tolerance = 1e-4, .floor = floor},
        {}, &work.descent);
    problem.refresh(work.x);
    const int nodes = level == 0 ? fine_.size() : cascade_.levels()[level - 1].graph.size();
    work.rotations.resize(nodes);
    parallel_for(nodes, [&](int i) { work.rotations[i] = Eigen::Quaterniond(problem.rotation(i)); });
    return work.rotations;
}

} // namespace sinew
