// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/nonlinear/arap/cascade.h"

#include "native/core/parallel.h"
#include "native/operators/rotation_fit.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>

namespace sinew {

namespace {

constexpr int coarsening = 4;
constexpr int fewest_nodes = 60;
constexpr int most_levels = 8;
constexpr double worthwhile = 0.7;    ///< a level that keeps more of the nodes is left out
constexpr double hat_radius = 1.6;    ///< of the up-weights, in cluster radii

constexpr double infinite = std::numeric_limits<double>::infinity();

using Entry = std::pair<double, int>;
using Front = std::priority_queue<Entry, std::vector<Entry>, std::greater<>>;

/// Clusters by farthest-point growth: each new seed is the node farthest from all seeds and
/// takes over what is nearer to it than to any other.
struct Clusters
{
    std::vector<int> label;
    std::vector<int> seeds;
    double radius = 0.0;

    Clusters(const ArapGraph& graph, const Points& rest, int wanted)
        : label(graph.size, -1), graph_(graph), rest_(rest), distance_(graph.size, infinite)
    {
        for (int i = 0; i < graph.size; ++i)
            if (!graph.idle[i] && label[i] < 0)
                grow(i); // one seed for each part of each region at least
        std::priority_queue<Entry> farthest;
        for (int i = 0; i < graph.size; ++i)
            if (!graph.idle[i])
                farthest.emplace(distance_[i], i);
        while (static_cast<int>(seeds.size()) < wanted && !farthest.empty()) {
            const auto [d, i] = farthest.top();
            farthest.pop();
            if (d > distance_[i]) {
                farthest.emplace(distance_[i], i); // outdated: it came nearer meanwhile
                continue;
            }
            if (d <= 0)
                break;
            radius = d;
            grow(i);
        }
    }

private:
    void grow(int seed)
    {
        const int id = static_cast<int>(seeds.size());
        seeds.push_back(seed);
        distance_[seed] = 0.0;
        label[seed] = id;
        Front front;
        front.emplace(0.0, seed);
        while (!front.empty()) {
            const auto [d, i] = front.top();
            front.pop();
            if (d > distance_[i])
                continue;
            for (int a = graph_.offsets[i]; a < graph_.offsets[i + 1]; ++a) {
                const int j = graph_.neighbours[a];
                if (graph_.hard[j] != graph_.hard[seed])
                    continue;
                const double further = d + (rest_.row(i) - rest_.row(j)).norm();
                if (further < distance_[j]) {
                    distance_[j] = further;
                    label[j] = id;
                    front.emplace(further, j);
                }
            }
        }
    }

    const ArapGraph& graph_;
    const Points& rest_;
    std::vector<double> distance_;
};

/// Squared hats over the graph distance to each seed, normalised at every node.
void set_up_weights(ArapLevel& level, const ArapGraph& fine, const Points& rest, const Clusters& clusters)
{
    const double reach = hat_radius * clusters.radius;
    std::vector<std::vector<std::pair<int, double>>> shares(fine.size);
    std::vector<double> distance(fine.size, infinite);
    std::vector<int> touched;
    for (int s = 0; s < static_cast<int>(clusters.seeds.size()); ++s) {
        Front front;
        const int seed = clusters.seeds[s];
        distance[seed] = 0.0;
        touched = {seed};
        front.emplace(0.0, seed);
        while (!front.empty()) {
            const auto [d, i] = front.top();
            front.pop();
            if (d > distance[i])
                continue;
            const double height = reach > 0 ? 1.0 - d / reach : 1.0;
            shares[i].emplace_back(s, height * height);
            for (int a = fine.offsets[i]; a < fine.offsets[i + 1]; ++a) {
                const int j = fine.neighbours[a];
                const double further = d + (rest.row(i) - rest.row(j)).norm();
                if (further < reach && further < distance[j]) {
                    if (distance[j] == infinite)
                        touched.push_back(j);
                    distance[j] = further;
                    front.emplace(further, j);
                }
            }
        }
        for (int i : touched)
            distance[i] = infinite;
    }
    level.up_offsets.assign(1, 0);
    for (int i = 0; i < fine.size; ++i) {
        if (shares[i].empty() && clusters.label[i] >= 0)
            shares[i].emplace_back(clusters.label[i], 1.0);
        double sum = 0.0;
        for (const auto& share : shares[i])
            sum += share.second;
        for (const auto& [node, weight] : shares[i]) {
            level.up_nodes.push_back(node);
            level.up_weights.push_back(weight / sum);
        }
        level.up_offsets.push_back(static_cast<int>(level.up_nodes.size()));
    }
}

void set_edges(ArapGraph& coarse, const ArapGraph& fine, const Points& fine_rest, const Points& coarse_rest,
               const std::vector<int>& label)
{
    std::vector<std::map<int, double>> crossing(coarse.size);
    for (int i = 0; i < fine.size; ++i)
        for (int a = fine.offsets[i]; a < fine.offsets[i + 1]; ++a) {
            const int p = label[i];
            const int q = label[fine.neighbours[a]];
            if (p != q && p >= 0)
                crossing[p][q] +=
                    fine.weights[a] * (fine_rest.row(i) - fine_rest.row(fine.neighbours[a])).norm();
        }
    coarse.offsets.assign(1, 0);
    for (int p = 0; p < coarse.size; ++p) {
        for (const auto& [q, weight] : crossing[p]) {
            const double length = (coarse_rest.row(p) - coarse_rest.row(q)).norm();
            coarse.neighbours.push_back(q);
            coarse.weights.push_back(length > 0 && weight > 0 ? weight / length : 1.0);
        }
        coarse.offsets.push_back(static_cast<int>(coarse.neighbours.size()));
    }
}

ArapLevel coarsen(const ArapGraph& fine, const Points& fine_rest, const Clusters& clusters)
{
    ArapLevel level;
    level.label = clusters.label;
    ArapGraph& coarse = level.graph;
    coarse.size = static_cast<int>(clusters.seeds.size());
    coarse.smoothing = fine.smoothing;
    coarse.idle.assign(coarse.size, false);
    coarse.hard.assign(coarse.size, -1);
    coarse.rigidity.assign(coarse.size, 0.0);
    level.members.assign(coarse.size, 0);
    for (int i = 0; i < fine.size; ++i) {
        const int p = level.label[i];
        if (p < 0)
            continue;
        ++level.members[p];
        coarse.hard[p] = fine.hard[i];
        coarse.rigidity[p] += fine.rigidity[i];
    }
    for (int p = 0; p < coarse.size; ++p)
        coarse.rigidity[p] /= level.members[p];

    std::map<std::pair<int, int>, double> pulls;
    for (const ArapPull& pull : fine.pulls)
        pulls[{level.label[pull.node], pull.handle}] += pull.stiffness;
    for (const auto& [key, stiffness] : pulls)
        coarse.pulls.push_back({key.first, key.second, stiffness});

    const Points rest = level.restrict(view(fine_rest));
    set_edges(coarse, fine, fine_rest, rest, level.label);
    coarse.set_metric();
    coarse.factorize(rest);
    set_up_weights(level, fine, fine_rest, clusters);

    const std::vector<int> old = coarse.renumber(rest);
    std::vector<int> renamed(coarse.size), members(coarse.size);
    for (int p = 0; p < coarse.size; ++p) {
        renamed[old[p]] = p;
        members[p] = level.members[old[p]];
    }
    level.members = std::move(members);
    for (int& p : level.label)
        p = p < 0 ? p : renamed[p];
    for (int& p : level.up_nodes)
        p = renamed[p];
    level.rest = level.restrict(view(fine_rest));
    return level;
}

/// Sign-aligned blend of the handles' rotations by harmonic weights.
void blend_handles(ArapProblem& problem, const ArapGraph& graph, const Poses& poses)
{
    const int handles = static_cast<int>(poses.size());
    Eigen::MatrixX4d q(handles, 4);
    for (int h = 0; h < handles; ++h)
        q.row(h) = Eigen::Quaterniond(fit_rotation(poses[h].leftCols<3>())).coeffs().transpose();
    // The dominant eigenvector is the mean of the rotations; quaternions on its far side turn.
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(q.transpose() * q);
    const Eigen::Vector4d mean = eigen.eigenvectors().col(3);
    for (int h = 0; h < handles; ++h)
        if (q.row(h).dot(mean) < 0)
            q.row(h) *= -1;

    // Departures from the mean: handles that agree leave nothing to round.
    MatrixX sides = MatrixX::Zero(graph.free_nodes.size(), 4);
    for (std::size_t f = 0; f < graph.free_nodes.size(); ++f) {
        const int i = graph.free_nodes[f];
        for (int a = graph.offsets[i]; a < graph.offsets[i + 1]; ++a) {
            const int j = graph.neighbours[a];
            if (graph.hard[j] >= 0)
                sides.row(f) += graph.metric[a] * (q.row(graph.hard[j]) - mean.transpose());
        }
    }
    for (const ArapPull& pull : graph.pulls)
        sides.row(graph.place[pull.node]) += pull.stiffness * (q.row(pull.handle) - mean.transpose());
    graph.position_factor.solve(sides, sides);

    for (int i = 0; i < graph.size; ++i) {
        if (graph.idle[i])
            continue;
        Eigen::Vector4d r = mean;
        if (graph.hard[i] >= 0)
            r = q.row(graph.hard[i]).transpose();
        else if ((mean + sides.row(graph.place[i]).transpose()).norm() > 1e-9)
            r += sides.row(graph.place[i]).transpose();
        problem.set_rotation(i, Eigen::Quaterniond(r.normalized()).toRotationMatrix());
    }
}

/// Rotations of a level to the next finer problem: sign-aligned quaternion means.
void hand_down(const ArapLevel& level, const std::vector<Eigen::Quaterniond>& q, ArapProblem& finer)
{
    parallel_for(static_cast<int>(level.label.size()), [&](int i) {
        if (level.label[i] < 0)
            return;
        const Eigen::Quaterniond& own = q[level.label[i]];
        Eigen::Vector4d sum = Eigen::Vector4d::Zero();
        for (int k = level.up_offsets[i]; k < level.up_offsets[i + 1]; ++k) {
            const Eigen::Quaterniond& r = q[level.up_nodes[k]];
            sum += (r.dot(own) < 0 ? -level.up_weights[k] : level.up_weights[k]) * r.coeffs();
        }
        finer.set_rotation(i, Eigen::Quaterniond(sum.normalized()).toRotationMatrix());
    });
}

} // namespace

void ArapLevel::restrict(const PointsView& finer, Points& mean) const
{
    mean.setZero(graph.size, 3);
    for (std::size_t i = 0; i < label.size(); ++i)
        if (label[i] >= 0)
            mean.row(label[i]) += finer.row(i);
    for (int p = 0; p < graph.size; ++p)
        mean.row(p) /= members[p];
}

void ArapGoals::set(const ArapGraph& graph, const Targets& goal)
{
    targets = goal.base();
    pulls.resize(graph.pulls.size(), 3);
    for (int i = 0; i < graph.size; ++i)
        if (graph.hard[i] >= 0)
            targets.row(i) = goal.of(i, graph.hard[i]).transpose();
    for (std::size_t k = 0; k < graph.pulls.size(); ++k)
        pulls.row(k) = goal.of(graph.pulls[k].node, graph.pulls[k].handle).transpose();
}

ArapCascade::ArapCascade(const ArapGraph& fine, const Points& rest, const Progress& progress)
{
    const ArapGraph* graph = &fine;
    const Points* points = &rest;
    levels_.reserve(most_levels); // `graph` points into it
    while (static_cast<int>(levels_.size()) < most_levels && graph->size / coarsening >= fewest_nodes) {
        progress.tick(0.6 + 0.4 * levels_.size() / most_levels, "clustering");
        const Clusters clusters(*graph, *points, graph->size / coarsening);
        const auto active = std::ranges::count(graph->idle, false);
        if (clusters.seeds.size() > worthwhile * active)
            break;
        levels_.push_back(coarsen(*graph, *points, clusters));
        graph = &levels_.back().graph;
        points = &levels_.back().rest;
    }
}

void ArapCascade::start(ArapProblem& fine_problem, const ArapGraph& fine, const Targets& targets,
                        std::vector<ArapWorkspace>& work) const
{
    if (levels_.empty()) {
        blend_handles(fine_problem, fine, targets.poses);
        return;
    }
    const int count = static_cast<int>(levels_.size());
    work.resize(count);
    if (targets.incoming) // its means on every level, fine to coarse
        for (int l = 0; l < count; ++l)
            levels_[l].restrict(l == 0 ? *targets.incoming : view(work[l - 1].base), work[l].base);

    for (int l = count - 1; l >= 0; --l) {
        const ArapGraph& graph = levels_[l].graph;
        Targets local{targets.poses, view(levels_[l].rest), {}, targets.from_rest};
        if (targets.incoming)
            local.incoming.emplace(view(work[l].base));
        ArapGoals& goals = work[l].goals;
        goals.set(graph, local);
        ArapProblem problem(graph, local.base(), goals.targets, goals.pulls, &work[l].buffers);
        if (l + 1 == count)
            blend_handles(problem, graph, targets.poses);
        else
            hand_down(levels_[l + 1], work[l + 1].rotations, problem);
        problem.positions_for_rotations(work[l].x);
        const double scale = targets.incoming ? graph.scale(local.base()) : graph.rest_scale;
        minimize(problem, work[l].x, {.max_iterations = 20, .tolerance = 1e-4, .floor = 1e-14 * scale}, {},
                 &work[l].descent);
        problem.refresh(work[l].x);
        work[l].rotations.resize(graph.size);
        parallel_for(graph.size,
                     [&](int i) { work[l].rotations[i] = Eigen::Quaterniond(problem.rotation(i)); });
    }
    hand_down(levels_.front(), work.front().rotations, fine_problem);
}

} // namespace sinew
