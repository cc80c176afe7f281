// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/graph/graph_iteration.h"

#include "native/core/parallel.h"
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

GraphIteration::GraphIteration(const GraphEdges& edges, const ClusterMap& map,
                               std::vector<GraphMatrix> matrices)
    : edges_(edges), map_(map)
{
    first_link_.assign(map.cluster_count() + 1, 0);
    const auto for_each = [&](auto&& body) {
        for (int i = 0; i < edges.size(); ++i) {
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

    for (GraphMatrix& given : matrices) {
        matrices_.push_back({std::move(given), {}});
        Matrix& matrix = matrices_.back();
        matrix.inverse_diagonal.resize(matrix.rows);
        parallel_for(matrix.rows, [&](int i) {
            double sum = 0.0;
            for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a)
                sum += matrix.entries[a];
            matrix.inverse_diagonal[i] = static_cast<float>(1.0 / (matrix.weight * sum + matrix.own[i]));
        });
    }
}

/// body(i, (A x)_i)
template <class Column, class Body>
void GraphIteration::multiply(const Matrix& matrix, const Work& work, const std::vector<Column>& x,
                              Body&& body) const
{
    work.progress->tick(0.0, "iterating");
    using Scalar = typename Column::Scalar;
    const double* const entries = matrix.entries.data();
    const int* const offsets = edges_.offsets.data();
    const int* const neighbours = edges_.neighbours.data();
    const auto weight = static_cast<Scalar>(matrix.weight);
    parallel_for(
        matrix.rows,
        [&](int i) {
            Column sum = Column::Zero();
            const Column& own = x[i];
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
    const int rows = matrix.rows, coarse_rows = matrix.coarse->size();
    const auto to_single = [&](int i) { work.r[i] = from[i].cast<float>(); };
    parallel_for(rows, to_single, grain);
    smooth(matrix, work);
    multiply(matrix, work, work.sum,
             [&](int i, const Four& product) { work.r[i] = from[i].cast<float>() - product; });
    work.coarse.resize(coarse_rows, 3);
    parallel_for(
        coarse_rows,
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
                if (shares.clusters[k] < coarse_rows)
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

void GraphIteration::solve(int number, const Points& b, Points& x, double error,
                           const Progress& progress) const
{
    const Matrix& matrix = matrices_[number];
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
        {error, most_iterations, Measure::remaining}, progress);
    if (!done.converged)
        throw NotConverged(
            "the multigrid stalls on this mesh: after " + std::to_string(done.count) +
            " iterations its error is not small enough; choose the factor, or repair or remesh the surface");
    parallel_for(rows, [&](int i) { x.row(i) = peak * work->solution[i].head<3>().matrix().transpose(); });
}

std::int64_t GraphIteration::bytes() const
{
    std::int64_t sum =
        static_cast<std::int64_t>(links_.size() * sizeof(Link) + first_link_.size() * sizeof(int));
    int rows = 0;
    for (const Matrix& matrix : matrices_) {
        rows = std::max(rows, matrix.rows);
        sum += matrix.rows * static_cast<std::int64_t>(sizeof(double) + sizeof(float));
    }
    return sum + rows * static_cast<std::int64_t>(4 * sizeof(Four) + 5 * sizeof(Eigen::Array4d));
}

} // namespace sinew
