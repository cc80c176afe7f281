// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/systems/multigrid_solver.h"

#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/solvers/multigrid/cycles.h"
#include "native/solvers/systems/conjugate_gradients.h"
#include "native/solvers/systems/not_converged.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

namespace sinew {

namespace {

constexpr double tolerance = 5e-5;
constexpr int twice_from = 2; ///< a level that costs little; a fifth of the iterations is saved
constexpr int most_iterations = 300;
constexpr int most_restarts = 3; ///< from the residual of the solution, where rounding made another one of it
constexpr double restarted = 2; ///< times the tolerance: an error that takes a restart

} // namespace

struct MultigridSolver::Impl
{
    Hierarchy hierarchy;
    std::vector<int> vertices; ///< (n) of the nodes of the finest level, and then of the other held ones
    std::vector<int> border_begin; ///< (n - free + 1)
    /// The links of held vertices with held ones that the finest level does not have, in units of the hierarchy.
    std::vector<std::pair<int, double>> border;
    std::vector<double>
        beyond_mass; ///< (n - nodes) inverse masses of the other held vertices; empty for order 1
    mutable Pool<Cycles> cycles; ///< each of several solves at the same time has its own

    Impl(const LinearSystem& system, const Progress& progress) : hierarchy(system, progress)
    {
        const Level& level = hierarchy.levels.front();
        const int n = static_cast<int>(system.points.rows());
        std::vector<bool> inside(n, false);
        vertices.reserve(n);
        for (const int u : hierarchy.unknowns)
            vertices.push_back(system.vertices[u]);
        vertices.insert(vertices.end(), hierarchy.held.begin(), hierarchy.held.end());
        for (const int v : vertices)
            inside[v] = true;
        for (int v = 0; v < n; ++v)
            if (!inside[v])
                vertices.push_back(v);
        border_begin.assign(1, 0);
        for (int i = level.free; i < n; ++i) {
            const int v = vertices[i];
            for (SparseMatrix::InnerIterator it(system.graph, v); it; ++it)
                if (it.row() != v && it.value() != 0.0 && !(inside[v] && inside[it.row()]))
                    border.emplace_back(static_cast<int>(it.row()), -it.value() / hierarchy.weight);
            border_begin.push_back(static_cast<int>(border.size()));
            if (i >= level.nodes && hierarchy.order > 1)
                beyond_mass.push_back(hierarchy.scale * hierarchy.weight * hierarchy.weight / system.mass[v]);
        }
        hierarchy.unknowns = {};
        hierarchy.held = {};
        progress.tick(0.8, "preparing the smoothers");
        workspace();
    }

    Pool<Cycles>::Lease workspace() const
    {
        return cycles.take([&] { return std::make_unique<Cycles>(hierarchy, twice_from); });
    }

    int free() const { return hierarchy.levels.front().free; }
    int nodes() const { return hierarchy.levels.front().nodes; }
    double energy(const Columns& y, const std::function<Wide(int)>& given) const;
};

/// The energy of y on the nodes of the finest level and of what is given for other vertices, in units of the hierarchy
/// and without pulls.
double MultigridSolver::Impl::energy(const Columns& y, const std::function<Wide(int)>& given) const
{
    const Level& level = hierarchy.levels.front();
    return parallel_sum(static_cast<int>(vertices.size()), [&](int i) {
        const Wide own = i < level.nodes ? y[i] : given(vertices[i]);
        Wide sum = Wide::Zero();
        double squares = 0.0;
        const auto add = [&](double w, const Wide& other) {
            sum += w * (own - other);
            squares += 0.5 * w * (own - other).square().sum();
        };
        for (int at = i < level.nodes ? level.link_begin[i] : 0;
             i < level.nodes && at < level.link_begin[i + 1]; ++at)
            add(level.weight(at), y[level.links[at].node]);
        for (int at = i < level.free ? 0 : border_begin[i - level.free];
             i >= level.free && at < border_begin[i - level.free + 1]; ++at)
            add(border[at].second, given(border[at].first));
        if (hierarchy.order == 1)
            return squares;
        const double inverse = i < level.nodes ? level.inverse_mass[i] : beyond_mass[i - level.nodes];
        return inverse * sum.square().sum() + hierarchy.membrane * squares;
    });
}

std::int64_t MultigridSolver::bytes_for(const LinearSystem& system)
{
    // Of a node: what a Level and a Work of Cycles keep; the vectors of the iteration; and three columns of x.
    constexpr std::int64_t of_level = 68, of_work = 5 * sizeof(Four) + 2 * sizeof(Wide),
                           of_solution = 5 * sizeof(Wide) + 3 * sizeof(double), of_link = sizeof(Level::Link);
    constexpr double levels[] = {1.15, 1.4}; // the nodes of all levels, as a multiple of those of the first
    const auto n = static_cast<std::int64_t>(system.vertices.size());
    const double share =
        static_cast<double>(n) / std::max<double>(static_cast<double>(system.graph.cols()), 1.0);
    const double links = share * static_cast<double>(system.graph.nonZeros() - system.graph.cols());
    const double all =
        levels[system.order > 1] * (static_cast<double>(n * (of_level + of_work)) + of_link * links);
    const double border = (1 - share) * static_cast<double>(system.graph.nonZeros());
    return static_cast<std::int64_t>(all + 4 * links + 16 * border) + n * of_solution;
}

MultigridSolver::MultigridSolver(const LinearSystem& system, const Progress& progress)
{
    require_memory(bytes_for(system), "the multigrid");
    impl_ = std::make_unique<Impl>(system, progress);
}

MultigridSolver::~MultigridSolver() = default;

MultigridSolver::Solution MultigridSolver::solve(RowMatrix& x, const RowMatrix* rhs, const RowMatrix* start,
                                                 const Progress& progress) const
{
    const Impl& own = *impl_;
    const Hierarchy& hierarchy = own.hierarchy;
    const Level& level = hierarchy.levels.front();
    const int free = level.free, nodes = level.nodes;
    const auto cycles = own.workspace();
    double reached = 0.0;
    const Progress ticks([&](double share, const char* stage) {
        reached = std::max(reached, share);
        progress.tick(reached, stage);
        return true;
    });
    struct Watch
    {
        Cycles& cycles;
        ~Watch() { cycles.watch(nullptr); }
    } const watch{*cycles};
    cycles->watch(&ticks);
    Solution solution;
    for (Eigen::Index first = 0; first < x.cols(); first += 4) {
        const auto count = std::min<Eigen::Index>(4, x.cols() - first);
        const auto row_of = [&](const RowMatrix& from, int v) {
            Wide row = Wide::Zero();
            row.head(count) = from.row(v).segment(first, count).transpose().array();
            return row;
        };
        /// In units of the hierarchy.
        const auto load = [&](int i) {
            return rhs ? Wide(hierarchy.scale * row_of(*rhs, own.vertices[i])) : Wide(Wide::Zero());
        };

        // A makes 0 of a common move but for what pulls: moves are counted from the mean of what is held or pulled to.
        Wide mean = Wide::Zero(), unit = Wide::Zero();
        double number = 0.0;
        const auto count_in = [&](const Wide& value, double weight) {
            mean += value;
            number += weight;
        };
        for (int i = free; i < nodes; ++i)
            count_in(row_of(x, own.vertices[i]), 1.0);
        for (int i = 0; nodes == free && rhs && i < free; ++i)
            count_in(load(i), level.pull[i]);
        mean /= number > 0 ? number : 1.0;
        const auto pulled = [&](int i) { return Wide(load(i) - static_cast<double>(level.pull[i]) * mean); };
        for (int i = free; i < nodes; ++i)
            unit = unit.max((row_of(x, own.vertices[i]) - mean).abs());
        for (int i = 0; rhs && i < free; ++i)
            unit = unit.max(pulled(i).abs());
        const double largest = unit.maxCoeff();
        if (!(largest > 0)) {
            parallel_for(free, [&](int i) {
                x.row(own.vertices[i]).segment(first, count) = mean.head(count).matrix().transpose();
            });
            continue;
        }

        HeldValues held;
        for (int i = free; i < nodes; ++i) {
            const Wide value = row_of(x, own.vertices[i]);
            held.value.emplace_back((value - mean) / largest);
            Wide beyond = Wide::Zero();
            for (int at = own.border_begin[i - free]; at < own.border_begin[i - free + 1]; ++at)
                beyond += own.border[at].second * (value - row_of(x, own.border[at].first));
            held.beyond.emplace_back(beyond / largest);
        }
        Columns y(nodes, Wide(Wide::Zero())), r(nodes, Wide(Wide::Zero()));
        std::copy(held.value.begin(), held.value.end(), y.begin() + free);
        const auto find_residual = [&] {
            cycles->multiply(y, held.beyond, r);
            parallel_for(free, [&](int i) { r[i] = pulled(i) / largest - r[i]; });
        };
        const auto size_of = [&](const Columns& columns) {
            Wide sum = Wide::Zero();
            for (int c = 0; c < 4; ++c)
                sum[c] = std::sqrt(parallel_sum(free, [&](int i) { return columns[i][c] * columns[i][c]; }));
            return sum;
        };
        find_residual();
        const Wide loads = size_of(r);
        if (start)
            parallel_for(free, [&](int i) { y[i] = (row_of(*start, own.vertices[i]) - mean) / largest; });
        else {
            std::vector<Four>& b = cycles->right_side();
            parallel_for(free, [&](int i) { b[i] = (pulled(i) / largest).cast<float>(); });
            y = cycles->full_cycle(held);
        }

        const auto multiply = [&](const Columns& from, Columns& to) { cycles->multiply(from, {}, to); };
        const auto precondition = [&](const Columns& from, Columns& to) {
            const Wide size = size_of(from).max(1e-300); // so that single precision holds it
            std::vector<Four>& b = cycles->right_side();
            parallel_for(free, [&](int i) { b[i] = (from[i] / size).cast<float>(); });
            const std::vector<Wide>* const found = cycles->cycle();
            if (!found)
                throw NotConverged("the multigrid diverges on this mesh; choose the factor");
            parallel_for(free, [&](int i) { to[i] = size * (*found)[i]; });
        };
        Stop stop{tolerance, most_iterations, Measure::corrected};
        for (int restart = 0;; ++restart) {
            find_residual();
            const Iteration done =
                conjugate_gradients(free, multiply, loads, r, y, precondition, stop, ticks);
            solution.iterations += done.count;
            stop.most_iterations -= done.count;
            if (restart > 0 && done.count == 0)
                break;
            if (!done.converged || restart == most_restarts)
                throw NotConverged(
                    "the multigrid stalls on this mesh: after " + std::to_string(solution.iterations) +
                    " iterations its error is not below 5e-5 of the move; choose the factor, or "
                    "repair or remesh the surface");
            if (hierarchy.order == 1) { // rounding makes no other solution of it
                find_residual();
                break;
            }
            stop.tolerance = restarted * tolerance;
            stop.measure = Measure::remaining;
        }
        const Wide left = size_of(r);
        solution.norms.load += std::pow(largest / hierarchy.scale * loads.matrix().norm(), 2);
        solution.norms.residual += std::pow(largest / hierarchy.scale * left.matrix().norm(), 2);
        const auto given = [&](int v) { return Wide((row_of(x, v) - mean) / largest); };
        solution.norms.energy += own.energy(y, given) * largest * largest / hierarchy.scale;
        parallel_for(free, [&](int i) {
            const Wide value = mean + largest * y[i];
            x.row(own.vertices[i]).segment(first, count) = value.head(count).matrix().transpose();
        });
        if (rhs)
            solution.norms.energy += parallel_sum(free, [&](int i) {
                return level.pull[i] / hierarchy.scale * (mean + largest * y[i]).square().sum();
            });
    }
    return solution;
}

Eigen::Index MultigridSolver::rows() const { return static_cast<Eigen::Index>(impl_->vertices.size()); }

std::int64_t MultigridSolver::bytes() const
{
    const auto size_of = [](const auto& values) {
        return static_cast<std::int64_t>(values.size() * sizeof(values.front()));
    };
    return impl_->hierarchy.bytes() + impl_->workspace()->bytes() + size_of(impl_->vertices) +
           size_of(impl_->border_begin) + size_of(impl_->border) + size_of(impl_->beyond_mass);
}

} // namespace sinew
