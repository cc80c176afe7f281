// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/constrained_quadratic.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/solvers/solved_system.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace sinew {

namespace {

/// The largest share of the factor's rows that may be given. In a solve, each costs as much as an unknown.
constexpr double most_given = 0.1;

/// y = row i of A x; A is symmetric, so its columns are its rows.
void multiply_row(const SparseMatrix& A, int i, const RowMatrix& x, double* y)
{
    const auto columns = x.cols();
    if (columns == 3) { // the sums of x, y and z stay in registers
        double sum[3] = {0, 0, 0};
        for (SparseMatrix::InnerIterator it(A, i); it; ++it) {
            const double* other = x.data() + 3 * it.row();
            for (int c = 0; c < 3; ++c)
                sum[c] += it.value() * other[c];
        }
        std::copy_n(sum, 3, y);
        return;
    }
    std::fill_n(y, columns, 0.0);
    for (SparseMatrix::InnerIterator it(A, i); it; ++it) {
        const double* other = x.data() + columns * it.row();
        for (Eigen::Index c = 0; c < columns; ++c)
            y[c] += it.value() * other[c];
    }
}

/// Calls `work`; the error of a singular system names a row of the matrix instead of an unknown.
template <class Work>
bool named(const ConstrainedQuadratic::Problem& problem, Work&& work)
{
    try {
        return work();
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed& error) {
        if (error.elements().empty())
            throw;
        const int row = problem.unknowns[error.elements().front()];
        throw FactorizationFailed("the system is singular; it broke down at vertex " + std::to_string(row),
                                  Error::Element::vertex, {row});
    }
}

} // namespace

void ConstrainedQuadratic::factorize(std::shared_ptr<const SparseMatrix> matrix,
                                     const std::vector<bool>& free, const std::vector<bool>& wider)
{
    Problem next{std::move(matrix), free, problem_.unknowns};
    if (named(next, [&] { return update(next); })) {
        adopt(std::move(next));
        return;
    }
    next.unknowns = unknowns_of(free, wider);
    factorize(std::move(next));
}

std::vector<int> ConstrainedQuadratic::unknowns_of(const std::vector<bool>& free,
                                                   const std::vector<bool>& wider)
{
    int unknown = 0, more = 0;
    for (std::size_t i = 0; i < free.size(); ++i) {
        unknown += free[i];
        more += !wider.empty() && wider[i] && !free[i];
    }
    const bool widens = more <= most_given * unknown;
    std::vector<int> unknowns;
    for (int i = 0; i < static_cast<int>(free.size()); ++i)
        if (free[i] || (widens && !wider.empty() && wider[i]))
            unknowns.push_back(i);
    return unknowns;
}

void ConstrainedQuadratic::restore(Problem problem) { factorize(std::move(problem)); }

void ConstrainedQuadratic::factorize(Problem next)
{
    if (!next.matrix) { // there was no problem before: the memory of the factor is freed
        factor_.factorize(SparseMatrix(0, 0));
        problem_ = std::move(next);
        return;
    }
    named(next, [&] {
        factor_.factorize(PrincipalBlock(*next.matrix, next.unknowns, next.free));
        return true;
    });
    adopt(std::move(next));
}

bool ConstrainedQuadratic::update(const Problem& next)
{
    if (!problem_.matrix || next.unknowns.empty())
        return false;
    const SparseMatrix &before = *problem_.matrix, &after = *next.matrix;
    const int n = static_cast<int>(after.cols());
    if (before.cols() != n || before.nonZeros() != after.nonZeros() ||
        !std::equal(before.outerIndexPtr(), before.outerIndexPtr() + n + 1, after.outerIndexPtr()) ||
        !std::equal(before.innerIndexPtr(), before.innerIndexPtr() + before.nonZeros(),
                    after.innerIndexPtr()))
        return false;
    int free = 0, held = 0;
    std::vector<char> unknown(n, false);
    for (const int u : next.unknowns)
        unknown[u] = true;
    for (int i = 0; i < n; ++i) {
        if (next.free[i] && !unknown[i])
            return false;
        free += next.free[i];
        held += unknown[i] && !next.free[i];
    }
    if (held > most_given * static_cast<double>(next.unknowns.size()))
        return false;

    // Both the row and the column of every entry that changes are marked.
    std::vector<char> changed(next.unknowns.size(), false);
    parallel_for(static_cast<int>(next.unknowns.size()), [&](int u) {
        const int column = next.unknowns[u];
        const int begin = after.outerIndexPtr()[column], end = after.outerIndexPtr()[column + 1];
        changed[u] = next.free[column] != problem_.free[column];
        for (int at = begin; at < end && !changed[u]; ++at) {
            const int row = after.innerIndexPtr()[at];
            changed[u] = unknown[row] && (next.free[row] != problem_.free[row] ||
                                          after.valuePtr()[at] != before.valuePtr()[at]);
        }
    });
    std::vector<int> list;
    for (int u = 0; u < static_cast<int>(changed.size()); ++u)
        if (changed[u])
            list.push_back(u);
    return factor_.update(PrincipalBlock(after, next.unknowns, next.free), list);
}

void ConstrainedQuadratic::adopt(Problem next)
{
    problem_ = std::move(next);
    const SparseMatrix& A = *problem_.matrix;
    bordering_.assign(A.cols(), false);
    parallel_for(static_cast<int>(A.cols()), [&](int i) {
        if (problem_.free[i])
            for (SparseMatrix::InnerIterator it(A, i); it && !bordering_[i]; ++it)
                bordering_[i] = !problem_.free[it.row()];
    });
}

void ConstrainedQuadratic::right_side_row(int row, const RowMatrix& x, const RowMatrix* rhs, double* b) const
{
    const auto columns = x.cols();
    if (rhs && problem_.free[row])
        std::copy_n(rhs->data() + columns * row, columns, b);
    else
        std::fill_n(b, columns, 0.0);
    if (!bordering_[row])
        return;
    for (SparseMatrix::InnerIterator it(*problem_.matrix, row); it; ++it)
        if (!problem_.free[it.row()])
            for (Eigen::Index c = 0; c < columns; ++c)
                b[c] -= it.value() * x(it.row(), c);
}

RowMatrix ConstrainedQuadratic::right_side(const RowMatrix& x, const RowMatrix* rhs) const
{
    RowMatrix b;
    right_side(x, rhs, b);
    return b;
}

void ConstrainedQuadratic::right_side(const RowMatrix& x, const RowMatrix* rhs, RowMatrix& b) const
{
    const int unknowns = static_cast<int>(problem_.unknowns.size());
    b.resize(unknowns, x.cols());
    parallel_for(unknowns,
                 [&](int u) { right_side_row(problem_.unknowns[u], x, rhs, b.data() + b.cols() * u); });
}

void ConstrainedQuadratic::solve(RowMatrix& x, const RowMatrix* rhs) const
{
    Workspace work;
    solve(x, rhs, work);
}

void ConstrainedQuadratic::solve(RowMatrix& x, const RowMatrix* rhs, Workspace& work) const
{
    right_side(x, rhs, work.unknowns);
    if (SolvedSystem* const solved = SolvedSystem::of_thread())
        solved->keep(problem_, x, work.unknowns);
    factor_.solve_rows(work.unknowns);
    const auto columns = x.cols();
    parallel_for(static_cast<int>(problem_.unknowns.size()), [&](int u) {
        const int row = problem_.unknowns[u];
        if (problem_.free[row])
            for (Eigen::Index c = 0; c < columns; ++c)
                x(row, c) = work.unknowns(u, c);
    });
}

ConstrainedQuadratic::Norms ConstrainedQuadratic::norms(const RowMatrix& x, const RowMatrix* rhs) const
{
    constexpr int smallest = 512, most_chunks = 64;
    const SparseMatrix& A = *problem_.matrix;
    const int n = static_cast<int>(A.cols());
    const auto columns = x.cols();
    const int grain = std::max(smallest, (n + most_chunks - 1) / most_chunks);
    std::vector<Norms> sums((n + grain - 1) / grain);
    parallel_chunks(n, grain, [&](int begin, int end) {
        Norms sum;
        std::vector<double> product(columns), load(columns);
        for (int i = begin; i < end; ++i) {
            const double* own = x.data() + columns * i;
            multiply_row(A, i, x, product.data());
            for (Eigen::Index c = 0; c < columns; ++c)
                sum.energy += own[c] * product[c];
            if (!problem_.free[i])
                continue;
            for (Eigen::Index c = 0; c < columns; ++c)
                sum.residual += std::pow(rhs ? product[c] - (*rhs)(i, c) : product[c], 2);
            if (!rhs && !bordering_[i])
                continue;
            right_side_row(i, x, rhs, load.data());
            for (Eigen::Index c = 0; c < columns; ++c)
                sum.load += load[c] * load[c];
        }
        sums[begin / grain] = sum;
    });
    Norms total;
    for (const Norms& part : sums) {
        total.energy += part.energy;
        total.residual += part.residual;
        total.load += part.load;
    }
    return total;
}

ConstrainedQuadratic::Forms ConstrainedQuadratic::forms(const RowMatrix& x, const RowMatrix* rhs) const
{
    constexpr int strip = 512, most_chunks = 64;
    const SparseMatrix& A = *problem_.matrix;
    const int n = static_cast<int>(A.cols());
    const auto columns = x.cols();
    const int grain = std::max(strip, (n + most_chunks - 1) / most_chunks);
    const MatrixX zero = MatrixX::Zero(columns, columns);
    std::vector<Forms> sums((n + grain - 1) / grain, Forms{zero, zero, zero});
    parallel_chunks(n, grain, [&](int chunk_begin, int chunk_end) {
        Forms& sum = sums[chunk_begin / grain];
        RowMatrix product(strip, columns), force(strip, columns), load(strip, columns);
        for (int begin = chunk_begin; begin < chunk_end; begin += strip) {
            const int count = std::min(strip, chunk_end - begin);
            for (int r = 0; r < count; ++r) {
                const int i = begin + r;
                multiply_row(A, i, x, product.data() + columns * r);
                if (problem_.free[i]) {
                    right_side_row(i, x, rhs, load.data() + columns * r);
                    force.row(r) = product.row(r);
                    if (rhs)
                        force.row(r) -= rhs->row(i);
                } else {
                    load.row(r).setZero();
                    force.row(r).setZero();
                }
            }
            const auto add = [count](MatrixX& form, const auto& left, const RowMatrix& right) {
                if (right.cols() <= 4)
                    form += left.transpose().lazyProduct(right.topRows(count));
                else
                    form.noalias() += left.transpose() * right.topRows(count);
            };
            add(sum.energy, x.middleRows(begin, count), product);
            add(sum.residual, force.topRows(count), force);
            add(sum.load, load.topRows(count), load);
        }
    });
    Forms total{zero, zero, zero};
    for (const Forms& part : sums) {
        total.energy += part.energy;
        total.residual += part.residual;
        total.load += part.load;
    }
    return total;
}

} // namespace sinew
