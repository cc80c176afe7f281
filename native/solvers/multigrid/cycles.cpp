// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/multigrid/cycles.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/solvers/sparse_columns.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace sinew {

namespace {

constexpr int degree = 4;
/// The factors of the steps of the smoother of this degree, Lottes 2023.
constexpr std::array<float, degree> factors{1.00391310427285F, 1.04035811188593F, 1.14863498546254F,
                                            1.38268869241000F};
constexpr int powers = 16;               ///< steps of the power iteration
constexpr float margin = 1.15F;           ///< of the bound over the largest eigenvalue that they find
constexpr int transfer_steps = 2;        ///< that smooth what goes to the next level and back
constexpr float transfer_damping = 0.6F;
constexpr int cascade_steps = 8;         ///< on the finest level but one; more below
constexpr int grain = 1024;

/// A sum over nodes for each column, in an order that does not depend on the threads.
template <class Body>
Eigen::Array4d sum_of(int count, Body&& body)
{
    std::vector<Eigen::Array4d> parts((count + grain - 1) / grain);
    parallel_chunks(count, grain, [&](int begin, int end) {
        Eigen::Array4d sum = Eigen::Array4d::Zero();
        for (int i = begin; i < end; ++i)
            sum += body(i);
        parts[begin / grain] = sum;
    });
    Eigen::Array4d total = Eigen::Array4d::Zero();
    for (const Eigen::Array4d& part : parts)
        total += part;
    return total;
}

/// A number in [-1, 1] for each node and column.
float scattered(std::uint32_t i)
{
    i = (i ^ 61U ^ i >> 16U) * 9U;
    i = (i ^ i >> 4U) * 0x27d4eb2dU;
    return static_cast<float>(i ^ i >> 15U) / 2147483648.0F - 1.0F;
}

/// The operator on the free nodes of a level, in double precision.
SparseMatrix assembled(const Level& level, int order, double membrane)
{
    SparseMatrix L = sparse_by_columns(level.nodes, level.free, [&](int c, SparseColumn& column) {
        column.add(c, 0.0);
        for (int at = level.link_begin[c]; at < level.link_begin[c + 1]; ++at) {
            const auto [j, w] = level.links[at];
            column.add(c, w);
            column.add(j, -static_cast<double>(w));
        }
    });
    const auto with_pulls = [&](SparseMatrix A) {
        for (int i = 0; i < level.free; ++i) // a node without any link is 0
            A.coeffRef(i, i) += level.inverse_diagonal[i] > 0 ? level.pull[i] : 1.0;
        return A;
    };
    const SparseMatrix square = L.topRows(level.free);
    if (order == 1)
        return with_pulls(square);
    const VectorX inverse = level.mass.cwiseInverse();
    return with_pulls(sparse_product(L.transpose(), inverse, L) + membrane * square);
}

} // namespace

Cycles::Cycles(const Hierarchy& hierarchy) : hierarchy_(hierarchy), work_(hierarchy.levels.size())
{
    for (int l = 0; l < static_cast<int>(work_.size()); ++l) {
        const Four zero = Four::Zero();
        Work& work = work_[l];
        for (std::vector<Four>* each : {&work.b, &work.x, &work.r, &work.step, &work.next, &work.middle})
            each->assign(hierarchy.levels[l].nodes, zero);
        work.largest = margin * largest_eigenvalue(l);
    }
    const Level& last = hierarchy.levels.back();
    try {
        coarsest_.factorize(assembled(last, hierarchy.order, hierarchy.membrane));
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed&) {
        throw FactorizationFailed(
            "on the coarsest level of multigrid, the system is singular or not positive definite");
    }
    columns_.resize(last.free, 4);
}

/// body(i, (L x)_i) for so many of the first nodes. Those of level.free are the free ones.
template <class Body>
void Cycles::multiply_by_laplacian(int l, int count, const std::vector<Four>& x, Body&& body)
{
    const Level& level = hierarchy_.levels[l];
    const Level::Link* const links = level.links.data();
    const int* const begin = level.link_begin.data();
    parallel_for(
        count,
        [&](int i) {
            Four sum = Four::Zero();
            const Four& own = x[i];
            for (int at = begin[i]; at < begin[i + 1]; ++at)
                sum += links[at].weight * (own - x[links[at].node]);
            body(i, sum);
        },
        grain);
}

/// body(i, (A x)_i) for the free nodes. It may change x where the operator is of order 2.
template <class Body>
void Cycles::multiply(int l, const std::vector<Four>& x, Body&& body)
{
    const Level& level = hierarchy_.levels[l];
    if (hierarchy_.order == 1) {
        multiply_by_laplacian(l, level.free, x,
                              [&](int i, const Four& sum) { body(i, Four(sum + level.pull[i] * x[i])); });
        return;
    }
    std::vector<Four>& middle = work_[l].middle;
    const auto membrane = static_cast<float>(hierarchy_.membrane);
    multiply_by_laplacian(l, level.nodes, x, [&](int i, const Four& sum) {
        middle[i] = level.inverse_mass[i] * sum + membrane * x[i];
    });
    multiply_by_laplacian(l, level.free, middle,
                          [&](int i, const Four& sum) { body(i, Four(sum + level.pull[i] * x[i])); });
}

/// The largest Rayleigh quotient after some steps of the power iteration, of four columns.
float Cycles::largest_eigenvalue(int l)
{
    const Level& level = hierarchy_.levels[l];
    std::vector<Four>&x = work_[l].x, &y = work_[l].r;
    for (int i = 0; i < level.free; ++i)
        for (int c = 0; c < 4; ++c)
            x[i][c] = scattered(static_cast<std::uint32_t>(4 * i + c));
    double largest = 0.0;
    for (int k = 0; k < powers; ++k) {
        multiply(l, x, [&](int i, const Four& product) { y[i] = product; });
        const Eigen::Array4d energy = sum_of(
            level.free, [&](int i) { return Eigen::Array4d(x[i].cast<double>() * y[i].cast<double>()); });
        const Eigen::Array4d square = sum_of(level.free, [&](int i) {
            const float inverse = level.inverse_diagonal[i];
            return Eigen::Array4d(x[i].cast<double>().square() * (inverse > 0 ? 1.0 / inverse : 0.0));
        });
        largest = (energy / square.max(1e-300)).maxCoeff();
        const Four scale = square.max(1e-30).sqrt().inverse().cast<float>();
        parallel_for(level.free, [&](int i) { x[i] = scale * level.inverse_diagonal[i] * y[i]; });
    }
    for (std::vector<Four>* each : {&x, &y})
        std::fill(each->begin(), each->end(), Four(Four::Zero()));
    return static_cast<float>(largest);
}

void Cycles::raise_bounds()
{
    for (Work& work : work_)
        work.largest *= 1.3F;
}

/// x += a polynomial of the residual of A x = b.
void Cycles::smooth(int l, bool from_zero)
{
    const Level& level = hierarchy_.levels[l];
    Work& work = work_[l];
    const float* const inverse = level.inverse_diagonal.data();
    const float first = 4.0F / (3.0F * work.largest);
    const auto begin = [&](int i, const Four& residual) {
        work.r[i] = residual;
        work.step[i] = first * inverse[i] * residual;
        work.next[i] = work.x[i] + factors[0] * work.step[i];
    };
    if (from_zero)
        parallel_for(
            level.free,
            [&](int i) {
                work.x[i].setZero();
                begin(i, work.b[i]);
            },
            grain);
    else
        multiply(l, work.x, [&](int i, const Four& product) { begin(i, work.b[i] - product); });
    work.x.swap(work.next);
    for (int k = 2; k <= degree; ++k) {
        const auto number = static_cast<float>(2 * k + 1);
        const float kept = static_cast<float>(2 * k - 3) / number,
                    added = static_cast<float>(8 * k - 4) / (number * work.largest), factor = factors[k - 1];
        multiply(l, work.step, [&](int i, const Four& product) {
            const Four residual = work.r[i] - product,
                       step = kept * work.step[i] + added * inverse[i] * residual;
            work.r[i] = residual;
            work.next[i] = step;
            work.x[i] += factor * step;
        });
        work.step.swap(work.next);
    }
}

void Cycles::find_residual(int l)
{
    Work& work = work_[l];
    multiply(l, work.x, [&](int i, const Four& product) { work.r[i] = work.b[i] - product; });
}

/// b of the next level from the residual of this one.
void Cycles::restrict_residual(int l)
{
    const Level& level = hierarchy_.levels[l];
    Work &work = work_[l], &below = work_[l + 1];
    for (int k = 0; hierarchy_.order == 2 && k < transfer_steps; ++k) {
        parallel_for(
            level.free, [&](int i) { work.step[i] = transfer_damping * level.inverse_of_L[i] * work.r[i]; },
            grain);
        multiply_by_laplacian(l, level.free, work.step,
                              [&](int i, const Four& product) { work.r[i] -= product; });
    }
    parallel_for(
        hierarchy_.levels[l + 1].free,
        [&](int c) {
            Four sum = Four::Zero();
            for (int at = level.child_begin[c]; at < level.child_begin[c + 1]; ++at)
                sum += level.children[at].weight * work.r[level.children[at].node];
            below.b[c] = sum;
        },
        grain);
}

/// x of this level from that of the next, or what is added to it.
void Cycles::prolong(int l, bool add)
{
    const Level& level = hierarchy_.levels[l];
    Work& work = work_[l];
    const std::vector<Four>& coarse = work_[l + 1].x;
    parallel_for(
        level.free,
        [&](int i) {
            const auto& parents = level.parents[i];
            const auto& shares = level.shares[i];
            work.step[i] = shares[0] * coarse[parents[0]] + shares[1] * coarse[parents[1]] +
                           shares[2] * coarse[parents[2]];
        },
        grain);
    for (int k = 0; hierarchy_.order == 2 && k < transfer_steps; ++k) {
        multiply_by_laplacian(l, level.free, work.step, [&](int i, const Four& product) {
            work.next[i] = work.step[i] - transfer_damping * level.inverse_of_L[i] * product;
        });
        work.step.swap(work.next);
    }
    parallel_for(
        level.free, [&](int i) { work.x[i] = add ? Four(work.x[i] + work.step[i]) : work.step[i]; }, grain);
}

void Cycles::solve_coarsest()
{
    Work& work = work_.back();
    for (int i = 0; i < columns_.rows(); ++i)
        columns_.row(i) = work.b[i].cast<double>().matrix().transpose();
    coarsest_.solve_rows(columns_);
    for (int i = 0; i < columns_.rows(); ++i)
        work.x[i] = columns_.row(i).transpose().array().cast<float>();
}

void Cycles::cycle(int l)
{
    if (l + 1 == static_cast<int>(work_.size()))
        return solve_coarsest();
    smooth(l, true);
    find_residual(l);
    restrict_residual(l);
    cycle(l + 1);
    prolong(l, true);
    smooth(l, false);
}

void Cycles::begin(const std::vector<Four>& b) { std::copy(b.begin(), b.end(), work_.front().b.begin()); }
void Cycles::finish(std::vector<Four>& x) const
{
    x.assign(work_.front().x.begin(), work_.front().x.begin() + hierarchy_.levels.front().free);
}

void Cycles::v_cycle(const std::vector<Four>& b, std::vector<Four>& x)
{
    begin(b);
    cycle(0);
    finish(x);
}

/// The right side of each level.
void Cycles::restrict_all(const std::vector<Four>& b)
{
    begin(b);
    for (int l = 0; l + 1 < static_cast<int>(work_.size()); ++l) {
        work_[l].r = work_[l].b;
        restrict_residual(l);
    }
    solve_coarsest();
}

void Cycles::full_cycle(const std::vector<Four>& b, std::vector<Four>& x)
{
    restrict_all(b);
    for (int l = static_cast<int>(work_.size()) - 2; l >= 0; --l) {
        prolong(l, false);
        // What is left is solved for by a V-cycle, whose right side is the residual.
        Work& work = work_[l];
        const std::vector<Four> before = work.x;
        find_residual(l);
        work.b = work.r;
        cycle(l);
        parallel_for(hierarchy_.levels[l].free, [&](int i) { work.x[i] += before[i]; });
    }
    finish(x);
}

void Cycles::descend(const std::vector<Four>& b, std::vector<Four>& x)
{
    restrict_all(b);
    for (int l = static_cast<int>(work_.size()) - 2; l >= 0; --l) {
        prolong(l, false);
        steps_of_conjugate_gradients(l, cascade_steps * (l + 1));
    }
    finish(x);
}

void Cycles::steps_of_conjugate_gradients(int l, int count)
{
    const Level& level = hierarchy_.levels[l];
    Work& work = work_[l];
    find_residual(l);
    const auto squares = [&] {
        return sum_of(level.free, [&](int i) {
            return Eigen::Array4d((level.inverse_diagonal[i] * work.r[i].square()).cast<double>());
        });
    };
    parallel_for(level.free, [&](int i) { work.step[i] = level.inverse_diagonal[i] * work.r[i]; });
    Eigen::Array4d rr = squares();
    for (int k = 0; k < count; ++k) {
        multiply(l, work.step, [&](int i, const Four& product) { work.next[i] = product; });
        const Eigen::Array4d energy = sum_of(level.free, [&](int i) {
            return Eigen::Array4d(work.step[i].cast<double>() * work.next[i].cast<double>());
        });
        const Four alpha = (energy > 0).select(rr / energy, 0.0).cast<float>();
        parallel_for(level.free, [&](int i) {
            work.x[i] += alpha * work.step[i];
            work.r[i] -= alpha * work.next[i];
        });
        const Eigen::Array4d before = std::exchange(rr, squares());
        const Four beta = (before > 0).select(rr / before, 0.0).cast<float>();
        parallel_for(level.free, [&](int i) {
            work.step[i] = level.inverse_diagonal[i] * work.r[i] + beta * work.step[i];
        });
    }
}

std::int64_t Cycles::bytes() const
{
    std::int64_t sum = coarsest_.bytes();
    for (const Work& work : work_)
        sum += static_cast<std::int64_t>(6 * work.b.size() * sizeof(Four));
    return sum;
}

} // namespace sinew
