// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/multigrid/cycles.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/solvers/sparse_columns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <utility>

namespace sinew {

namespace {

constexpr int degree = 4;
/// The factors of the steps of the smoother of this degree, Lottes 2023.
constexpr std::array<float, degree> factors{1.00391310427285F, 1.04035811188593F, 1.14863498546254F,
                                            1.38268869241000F};
constexpr int powers = 16;               ///< steps of the power iteration
constexpr float margin = 1.15F;           ///< of the bound over the largest eigenvalue that they find
constexpr float close_bound =
    2.1F;      ///< up to which Gershgorin's bound takes the place of that power iteration
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

/// Gershgorin's bound of the eigenvalues of an A of order 1 with the diagonal 1: 2 where no weight is negative.
float circle_bound(const Level& level)
{
    float bound = 1.0F;
    for (int i = 0; i < level.free; ++i) {
        float sum = 0.0F;
        for (int at = level.link_begin[i]; at < level.link_begin[i + 1]; ++at)
            sum += std::abs(level.links[at].weight);
        bound = std::max(bound, 1.0F + sum * level.inverse_diagonal[i]);
    }
    return bound;
}

} // namespace

Cycles::Cycles(const Hierarchy& hierarchy, int twice_from)
    : hierarchy_(hierarchy), twice_from_(twice_from), work_(hierarchy.levels.size())
{
    for (int l = 0; l < static_cast<int>(work_.size()); ++l) {
        Work& work = work_[l];
        for (std::vector<Four>* each : {&work.b, &work.r, &work.step, &work.middle, &work.sum})
            each->assign(hierarchy.levels[l].nodes, Four::Zero());
        for (std::vector<Wide>* each : {&work.x, &work.other})
            each->assign(hierarchy.levels[l].nodes, Wide::Zero());
        if (is_twice(l))
            work.first = work.x;
        const float bound = circle_bound(hierarchy.levels[l]);
        work.largest = hierarchy.order == 1 && bound <= close_bound ? bound : margin * largest_eigenvalue(l);
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
template <class Column, class Body>
void Cycles::multiply_by_laplacian(int l, int count, const std::vector<Column>& x, Body&& body)
{
    const Level& level = hierarchy_.levels[l];
    const Level::Link* const links = level.links.data();
    const int* const begin = level.link_begin.data();
    if (l == 0 && progress_)
        progress_->tick(0.0, "iterating");
    const auto multiply_by = [&](const auto& weight) {
        parallel_for(
            count,
            [&](int i) {
                Column sum = Column::Zero();
                const Column& own = x[i];
                for (int at = begin[i]; at < begin[i + 1]; ++at)
                    sum += typename Column::Scalar(weight(at)) * (own - x[links[at].node]);
                body(i, sum);
            },
            grain);
    };
    if (std::is_same_v<Column, Wide> && !level.rounding.empty())
        multiply_by([&](int at) { return level.weight(at); });
    else
        multiply_by([&](int at) { return links[at].weight; });
}

/// body(i, (A x)_i) for the free nodes. Where the operator is of order 2, body may change x.
template <class Column, class Body>
void Cycles::multiply(int l, const std::vector<Column>& x, std::vector<Column>& middle, Body&& body)
{
    using Scalar = typename Column::Scalar;
    const Level& level = hierarchy_.levels[l];
    const auto last = [&](int i, const Column& sum) { body(i, Column(sum + Scalar(level.pull[i]) * x[i])); };
    if (hierarchy_.order == 1)
        return multiply_by_laplacian(l, level.free, x, last);
    const auto membrane = static_cast<Scalar>(hierarchy_.membrane);
    multiply_by_laplacian(l, level.nodes, x, [&](int i, const Column& sum) {
        middle[i] = Scalar(level.inverse_mass[i]) * sum + membrane * x[i];
    });
    multiply_by_laplacian(l, level.free, middle, last);
}

/// The largest Rayleigh quotient after some steps of the power iteration, of four columns.
float Cycles::largest_eigenvalue(int l)
{
    const Level& level = hierarchy_.levels[l];
    std::vector<Four>&x = work_[l].sum, &y = work_[l].r;
    for (int i = 0; i < level.free; ++i)
        for (int c = 0; c < 4; ++c)
            x[i][c] = scattered(static_cast<std::uint32_t>(4 * i + c));
    double largest = 0.0;
    for (int k = 0; k < powers; ++k) {
        multiply(l, x, work_[l].middle, [&](int i, const Four& product) { y[i] = product; });
        const Wide energy =
            sum_of(level.free, [&](int i) { return Wide(x[i].cast<double>() * y[i].cast<double>()); });
        const Wide square = sum_of(level.free, [&](int i) {
            const float inverse = level.inverse_diagonal[i];
            return Wide(x[i].cast<double>().square() * (inverse > 0 ? 1.0 / inverse : 0.0));
        });
        largest = (energy / square.max(1e-300)).maxCoeff();
        const Four scale = square.max(1e-30).sqrt().inverse().cast<float>();
        parallel_for(level.free, [&](int i) { x[i] = scale * level.inverse_diagonal[i] * y[i]; });
    }
    return static_cast<float>(largest);
}

void Cycles::raise_bounds()
{
    ++raises_;
    for (Work& work : work_)
        work.largest *= 1.3F;
}

/// sum = a polynomial of r, which is used up.
void Cycles::smooth(int l)
{
    const Level& level = hierarchy_.levels[l];
    Work& work = work_[l];
    const float* const inverse = level.inverse_diagonal.data();
    const float first = 4.0F / (3.0F * work.largest);
    parallel_for(
        level.free,
        [&](int i) {
            work.step[i] = first * inverse[i] * work.r[i];
            work.sum[i] = factors[0] * work.step[i];
        },
        grain);
    const bool in_place = hierarchy_.order == 2;
    std::vector<Four>& next = in_place ? work.step : work.middle;
    for (int k = 2; k <= degree; ++k) {
        const auto number = static_cast<float>(2 * k + 1);
        const float kept = static_cast<float>(2 * k - 3) / number,
                    added = static_cast<float>(8 * k - 4) / (number * work.largest), factor = factors[k - 1];
        multiply(l, work.step, work.middle, [&](int i, const Four& product) {
            const Four residual = work.r[i] - product,
                       step = kept * work.step[i] + added * inverse[i] * residual;
            work.r[i] = residual;
            next[i] = step;
            work.sum[i] += factor * step;
        });
        if (!in_place)
            work.step.swap(work.middle);
    }
}

/// b of the next level from r of this one, which is used up.
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

/// x of this level from that of the next.
/// \param x, other  have what is on held nodes; `other` is overwritten elsewhere.
void Cycles::prolong(int l, const std::vector<Wide>& coarse, std::vector<Wide>& x, std::vector<Wide>& other)
{
    const Level& level = hierarchy_.levels[l];
    parallel_for(
        level.free,
        [&](int i) {
            x[i].setZero();
            for (int k = 0; k < 3; ++k)
                x[i] += static_cast<double>(level.shares[i][k]) * coarse[level.parents[i][k]];
        },
        grain);
    for (int k = 0; hierarchy_.order == 2 && k < transfer_steps; ++k) {
        multiply_by_laplacian(l, level.free, x, [&](int i, const Wide& product) {
            other[i] = x[i] - static_cast<double>(transfer_damping * level.inverse_of_L[i]) * product;
        });
        x.swap(other);
    }
}

void Cycles::solve_coarsest()
{
    Work& work = work_.back();
    for (int i = 0; i < columns_.rows(); ++i)
        columns_.row(i) = work.b[i].cast<double>().matrix().transpose();
    coarsest_.solve_rows(columns_);
    for (int i = 0; i < columns_.rows(); ++i)
        work.x[i] = columns_.row(i).transpose().array();
}

void Cycles::cycle(int l)
{
    if (l + 1 == static_cast<int>(work_.size()))
        return solve_coarsest();
    const Level& level = hierarchy_.levels[l];
    Work& work = work_[l];
    std::copy_n(work.b.begin(), level.free, work.r.begin());
    smooth(l);
    multiply(l, work.sum, work.middle, [&](int i, const Four& product) { work.r[i] = work.b[i] - product; });
    restrict_residual(l);
    visit(l + 1);
    std::fill(work.other.begin() + level.free, work.other.end(), Wide(Wide::Zero()));
    prolong(l, work_[l + 1].x, work.x, work.other);
    const auto add = [&] {
        parallel_for(level.free, [&](int i) { work.x[i] += work.sum[i].cast<double>(); }, grain);
    };
    add();
    multiply(l, work.x, work.other, [&](int i, const Wide& product) {
        work.r[i] = (work.b[i].cast<double>() - product).cast<float>();
    });
    smooth(l);
    add();
}

/// x of a level for its b, which is used up.
void Cycles::visit(int l)
{
    cycle(l);
    if (!is_twice(l))
        return;
    Work& work = work_[l];
    work.first = work.x;
    multiply(l, work.x, work.other, [&](int i, const Wide& product) {
        work.b[i] = (work.b[i].cast<double>() - product).cast<float>();
    });
    cycle(l);
    parallel_for(hierarchy_.levels[l].free, [&](int i) { work.x[i] += work.first[i]; }, grain);
}

const std::vector<Wide>* Cycles::cycle()
{
    constexpr int most_raises = 8;
    const Work& work = work_.front();
    const auto is_definite = [&] {
        const int free = hierarchy_.levels.front().free;
        const Wide sum = sum_of(free, [&](int i) { return Wide(work.b[i].cast<double>() * work.x[i]); });
        return (sum >= 0.0).all() || !sum.isFinite().all();
    };
    for (cycle(0); !is_definite(); cycle(0)) {
        if (raises_ == most_raises)
            return nullptr;
        raise_bounds();
    }
    return &work.x;
}

void Cycles::multiply(const std::vector<Wide>& x, const std::vector<Wide>& beyond, std::vector<Wide>& y)
{
    multiply_all(0, x, beyond, [&](int i, const Wide& product) { y[i] = product; });
}

/// The right side of each level.
void Cycles::restrict_all()
{
    for (int l = 0; l + 1 < static_cast<int>(work_.size()); ++l) {
        work_[l].r = work_[l].b;
        restrict_residual(l);
    }
}

/// body(i, (A x)_i) for the free nodes, with held nodes that are not 0.
template <class Body>
void Cycles::multiply_all(int l, const std::vector<Wide>& x, const std::vector<Wide>& beyond, Body&& body)
{
    const Level& level = hierarchy_.levels[l];
    Work& work = work_[l];
    const auto last = [&](int i, const Wide& sum) {
        body(i, Wide(sum + static_cast<double>(level.pull[i]) * x[i]));
    };
    if (hierarchy_.order == 1)
        return multiply_by_laplacian(l, level.free, x, last);
    multiply_by_laplacian(l, level.nodes, x, [&](int i, const Wide& sum) {
        const Wide all = i < level.free || beyond.empty() ? sum : Wide(sum + beyond[i - level.free]);
        work.other[i] = static_cast<double>(level.inverse_mass[i]) * all + hierarchy_.membrane * x[i];
    });
    multiply_by_laplacian(l, level.free, work.other, last);
}

std::vector<Wide> Cycles::full_cycle(const HeldValues& held)
{
    restrict_all();
    const int last = static_cast<int>(work_.size()) - 1;
    std::vector<HeldValues> values(work_.size());
    for (int l = 0; l <= last; ++l) {
        const Level& level = hierarchy_.levels[l];
        HeldValues& own = values[l];
        own.value.assign(level.nodes - level.free, Wide::Zero());
        own.beyond = own.value;
        if (l == 0 && !held.value.empty())
            own = held;
        const Level* const above = l > 0 ? &hierarchy_.levels[l - 1] : nullptr;
        for (int c = level.free; above && c < level.nodes; ++c) {
            int count = 0;
            for (int at = above->child_begin[c]; at < above->child_begin[c + 1]; ++at)
                if (const int i = above->children[at].node - above->free; i >= 0) {
                    own.value[c - level.free] += values[l - 1].value[i];
                    own.beyond[c - level.free] += values[l - 1].beyond[i];
                    ++count;
                }
            own.value[c - level.free] /= std::max(count, 1);
        }
    }
    std::vector<Wide> coarse, x;
    for (int l = last; l >= 0; --l) {
        const Level& level = hierarchy_.levels[l];
        x.assign(level.nodes, Wide::Zero());
        std::copy(values[l].value.begin(), values[l].value.end(), x.begin() + level.free);
        if (l < last) {
            std::vector<Wide> other = x;
            prolong(l, coarse, x, other);
        }
        if (l > 0) {
            multiply_all(l, x, values[l].beyond, [&](int i, const Wide& product) {
                work_[l].b[i] = (work_[l].b[i].cast<double>() - product).cast<float>();
            });
            cycle(l);
            parallel_for(level.free, [&](int i) { x[i] += work_[l].x[i]; }, grain);
        }
        coarse.swap(x);
    }
    return coarse;
}

const std::vector<Wide>& Cycles::descend()
{
    restrict_all();
    solve_coarsest();
    for (int l = static_cast<int>(work_.size()) - 2; l >= 0; --l) {
        Work& work = work_[l];
        std::fill(work.other.begin() + hierarchy_.levels[l].free, work.other.end(), Wide(Wide::Zero()));
        prolong(l, work_[l + 1].x, work.x, work.other);
        steps_of_conjugate_gradients(l, cascade_steps * (l + 1));
    }
    return work_.front().x;
}

void Cycles::steps_of_conjugate_gradients(int l, int count)
{
    const Level& level = hierarchy_.levels[l];
    Work& work = work_[l];
    multiply(l, work.x, work.other, [&](int i, const Wide& product) {
        work.r[i] = (work.b[i].cast<double>() - product).cast<float>();
    });
    const auto squares = [&] {
        return sum_of(level.free, [&](int i) {
            return Wide((level.inverse_diagonal[i] * work.r[i].square()).cast<double>());
        });
    };
    parallel_for(level.free, [&](int i) { work.step[i] = level.inverse_diagonal[i] * work.r[i]; });
    Wide rr = squares();
    for (int k = 0; k < count; ++k) {
        multiply(l, work.step, work.middle, [&](int i, const Four& product) { work.sum[i] = product; });
        const Wide energy = sum_of(level.free, [&](int i) {
            return Wide(work.step[i].cast<double>() * work.sum[i].cast<double>());
        });
        const Four alpha = (energy > 0).select(rr / energy, 0.0).cast<float>();
        parallel_for(level.free, [&](int i) {
            work.x[i] += (alpha * work.step[i]).cast<double>();
            work.r[i] -= alpha * work.sum[i];
        });
        const Wide before = std::exchange(rr, squares());
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
        sum += static_cast<std::int64_t>(work.b.size() * (5 * sizeof(Four) + 2 * sizeof(Wide)) +
                                         work.first.size() * sizeof(Wide));
    return sum;
}

} // namespace sinew
