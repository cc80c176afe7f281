// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/graph_iteration.h"

#include "native/core/parallel.h"
#include "native/local_global/arap/arap_system.h"
#include "native/solvers/systems/not_converged.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

namespace sinew {

namespace {

constexpr int degree = 4;
/// The factors of the steps of the smoother of this degree, Lottes 2023.
constexpr std::array<float, degree> factors{1.00391310427285F, 1.04035811188593F, 1.14863498546254F,
                                            1.38268869241000F};
constexpr float largest = 2.0F; ///< eigenvalue of a matrix with a dominant diagonal of 1
constexpr int most_iterations = 60;
constexpr int grain = 1024;

} // namespace

GraphIteration::GraphIteration(const ArapSystem& fine, const Points& rest, const ClusterMap& map,
                               const ArapSystem& coarse)
    : edges_(fine.nodes().edges()), map_(map)
{
    const int nodes = fine.size();
    first_link_.assign(map.cluster_count() + 1, 0);
    const auto for_each = [&](auto&& body) {
        for (int i = 0; i < nodes; ++i) {
            const ClusterMap::Shares shares = map.shares(i);
            for (int k = 0; k < shares.count; ++k)
                body(i, shares.clusters[k], static_cast<float>(shares.weights[k]));
        }
    };
    for_each([&](int, int p, float) { ++first_link_[p + 1]; });
    std::partial_sum(first_link_.begin(), first_link_.end(), first_link_.begin());
    links_.resize(first_link_.back());
    std::vector<int> next(first_link_.begin(), first_link_.end() - 1);
    for_each([&](int i, int p, float share) { links_[next[p]++] = {i, share}; });

    positions_.rows = fine.free_count();
    positions_.coarse_rows = coarse.free_count();
    positions_.entries = &fine.laplacian();
    positions_.own.assign(positions_.rows, 0.0);
    for (const GraphPull& pull : fine.nodes().pulls())
        positions_.own[pull.node] += pull.stiffness;
    positions_.coarse = &coarse.position_factor();
    complete(positions_);
    if (!fine.is_smooth())
        return;
    rotations_.rows = nodes;
    rotations_.coarse_rows = coarse.size();
    rotations_.weight = 4 * fine.cells().smoothing;
    rotations_.entries = &fine.laplacian();
    if (fine.cells().rims) {
        rotation_entries_ = edges_.weights;
        for (int i = 0; i < nodes; ++i)
            for (int a = edges_.offsets[i]; a < edges_.offsets[i + 1]; ++a)
                rotation_entries_[a] *= fine.cells().edge_rigidity(i, edges_.neighbours[a]);
        rotations_.entries = &rotation_entries_;
    }
    rotations_.own = fine.cells().moments(edges_, rest);
    rotations_.coarse = &coarse.rotation_factor();
    complete(rotations_);
}

GraphIteration::~GraphIteration() = default;

void GraphIteration::complete(Matrix& matrix) const
{
    matrix.inverse_diagonal.resize(matrix.rows);
    parallel_for(matrix.rows, [&](int i) {
        double sum = 0.0;
        for (int a = edges_.offsets[i]; a < edges_.offsets[i + 1]; ++a)
            sum += (*matrix.entries)[a];
        matrix.inverse_diagonal[i] = static_cast<float>(1.0 / (matrix.weight * sum + matrix.own[i]));
    });
}

/// body(i, (A x)_i)
template <class Column, class Body>
void GraphIteration::multiply(const Matrix& matrix, const Work& work, const std::vector<Column>& x,
                              Body&& body) const
{
    work.progress->tick(0.0, "iterating");
    using Scalar = typename Column::Scalar;
    const double* const entries = matrix.entries->data();
    const int* const offsets = edges_.offsets.data();
    const int* const neighbours = edges_.neighbours.data();
    const auto weight = static_cast<Scalar>(matrix.weight);
    parallel_for(
        matrix.rows,
        [&](int i) {
            Column sum = Column::Zero();
            const Column own = x[i];
            for (int a = offsets[i]; a < offsets[i + 1]; ++a) {
                const int j = neighbours[a];
                const auto w = static_cast<Scalar>(entries[a]);
                if (j < matrix.rows)
                    sum += w * (own - x[j]);
                else
                    sum += w * own;
            }
            body(i, Column(weight * sum + static_cast<Scalar>(matrix.own[i]) * own));
        },
        grain);
}

/// sum = a polynomial of r, which is used up.
void GraphIteration::smooth(const Matrix& matrix, Work& work) const
{
    const float* const inverse = matrix.inverse_diagonal.data();
    parallel_for(
        matrix.rows,
        [&](int i) {
            work.step[i] = 4.0F / (3.0F * largest) * inverse[i] * work.r[i];
            work.sum[i] = factors[0] * work.step[i];
        },
        grain);
    for (int k = 2; k <= degree; ++k) {
        const auto number = static_cast<float>(2 * k + 1);
        const float kept = static_cast<float>(2 * k - 3) / number,
                    added = static_cast<float>(8 * k - 4) / (number * largest), factor = factors[k - 1];
        multiply(matrix, work, work.step, [&](int i, const Four& product) {
            work.r[i] -= product;
            work.next[i] = kept * work.step[i] + added * inverse[i] * work.r[i];
            work.sum[i] += factor * work.next[i];
        });
        work.step.swap(work.next);
    }
}

/// to = B from
void GraphIteration::cycle(const Matrix& matrix, Work& work, const Columns& from, Columns& to) const
{
    const int rows = matrix.rows;
    const auto to_single = [&](int i) { work.r[i] = from[i].cast<float>(); };
    parallel_for(rows, to_single, grain);
    smooth(matrix, work);
    multiply(matrix, work, work.sum,
             [&](int i, const Four& product) { work.r[i] = from[i].cast<float>() - product; });
    work.coarse.resize(matrix.coarse_rows, 3);
    parallel_for(
        matrix.coarse_rows,
        [&](int p) {
            Four sum = Four::Zero();
            for (int k = first_link_[p]; k < first_link_[p + 1]; ++k)
                if (links_[k].node < rows)
                    sum += links_[k].share * work.r[links_[k].node];
            work.coarse.row(p) = sum.head<3>().cast<double>().matrix().transpose();
        },
        grain);
    matrix.coarse->solve(work.coarse, work.coarse);
    parallel_for(
        rows,
        [&](int i) {
            const ClusterMap::Shares shares = map_.shares(i);
            Eigen::Array4d sum = work.sum[i].cast<double>();
            for (int k = 0; k < shares.count; ++k)
                if (shares.clusters[k] < matrix.coarse_rows)
                    sum.head<3>() +=
                        shares.weights[k] * work.coarse.row(shares.clusters[k]).transpose().array();
            to[i] = sum;
        },
        grain);
    multiply(matrix, work, to,
             [&](int i, const Eigen::Array4d& product) { work.r[i] = (from[i] - product).cast<float>(); });
    smooth(matrix, work);
    parallel_for(rows, [&](int i) { to[i] += work.sum[i].cast<double>(); }, grain);
}

void GraphIteration::solve(const Matrix& matrix, const Points& b, Points& x, double error,
                           const Progress& progress) const
{
    const int rows = matrix.rows;
    const auto work = work_.take([] { return std::make_unique<Work>(); });
    for (std::vector<Four>* each : {&work->r, &work->step, &work->next, &work->sum})
        each->resize(std::max<std::size_t>(each->size(), rows));
    work->progress = &progress;
    work->load.resize(rows);
    work->solution.assign(rows, Eigen::Array4d::Zero());
    const double peak = rows > 0 ? b.cwiseAbs().maxCoeff() : 0.0;
    x.resize(rows, 3);
    if (!(peak > 0)) {
        x.setZero();
        return;
    }
    parallel_for(rows, [&](int i) { work->load[i] << b.row(i).transpose().array() / peak, 0.0; });
    Eigen::Array4d load = Eigen::Array4d::Zero();
    for (int c = 0; c < 3; ++c)
        load[c] = std::sqrt(parallel_sum(rows, [&](int i) { return work->load[i][c] * work->load[i][c]; }));
    const Iteration done = conjugate_gradients(
        rows,
        [&](const Columns& from, Columns& to) {
            multiply(matrix, *work, from, [&](int i, const Eigen::Array4d& product) { to[i] = product; });
        },
        load, work->load, work->solution,
        [&](const Columns& from, Columns& to) { cycle(matrix, *work, from, to); },
        {.tolerance = error,
         .most_iterations = most_iterations,
         .by_error = true,
         .together = true,
         .adds_estimate = true},
        progress);
    if (!done.converged)
        throw NotConverged(
            "the multigrid stalls on this mesh: after " + std::to_string(done.count) +
            " iterations its error is not small enough; choose the factor, or repair or remesh the surface");
    parallel_for(rows, [&](int i) { x.row(i) = peak * work->solution[i].head<3>().matrix().transpose(); });
}

void GraphIteration::solve_positions(const Points& b, Points& x, double error, const Progress& progress) const
{
    solve(positions_, b, x, error, progress);
}

void GraphIteration::solve_rotations(const Points& b, Points& x, double error, const Progress& progress) const
{
    solve(rotations_, b, x, error, progress);
}

std::int64_t GraphIteration::bytes() const
{
    const auto rows = static_cast<std::int64_t>(std::max(positions_.rows, rotations_.rows));
    std::int64_t sum = static_cast<std::int64_t>(links_.size() * sizeof(Link) + first_link_.size() * 4 +
                                                 rotation_entries_.size() * 8) +
                       rows * (4 * sizeof(Four) + 5 * sizeof(Eigen::Array4d));
    for (const Matrix* matrix : {&positions_, &rotations_})
        sum += static_cast<std::int64_t>(matrix->own.size() * 12);
    return sum;
}

} // namespace sinew
