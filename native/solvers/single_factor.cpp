// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/single_factor.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/solvers/engines/cholmod_factor.h"
#include "native/solvers/patch_dissection.h"
#include "native/solvers/smallest_factor.h"
#include "native/solvers/supernodal/kernels.h"

#include <algorithm>
#include <new>
#include <numeric>
#include <optional>
#include <string>

namespace sinew {

namespace {

constexpr int grain = 4096;
/// Unknowns below which minimum degree finds a factor that is about as small, in a tenth of the time.
constexpr int fewest_for_smallest = 10'000;

/// The lower triangle of the matrix after unknown order[i] has become number i.
SparseMatrix ordered(const SparseMatrix& matrix, const std::vector<int>& order)
{
    std::vector<int> place(order.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        place[order[i]] = static_cast<int>(i);
    std::vector<Eigen::Triplet<double>> entries;
    for (int c = 0; c < matrix.cols(); ++c)
        for (SparseMatrix::InnerIterator it(matrix, c); it; ++it)
            if (it.row() >= c)
                entries.emplace_back(std::max(place[it.row()], place[c]), std::min(place[it.row()], place[c]),
                                     it.value());
    SparseMatrix lower(matrix.rows(), matrix.cols());
    lower.setFromTriplets(entries.begin(), entries.end());
    return lower;
}

} // namespace

Ordering smallest_factor() { return have_cholmod() ? Ordering::nested_dissection : Ordering::minimum_degree; }

std::vector<int> fill_reducing_order(const SparseMatrix& matrix)
{
    if (matrix.cols() == 0)
        return {};
    try {
        const bool middling = matrix.cols() >= fewest_for_smallest && matrix.cols() < fewest_to_dissect;
        return elimination_order(matrix, middling ? smallest_factor() : Ordering::automatic);
    } catch (const std::bad_alloc&) {
        throw OutOfMemory("memory ran out before the size of the factor was known: use fewer vertices");
    }
}

void SingleFactor::factorize(const SparseMatrix& matrix, const std::vector<int>& order)
{
    const auto backend = have_cholmod() ? FactorBackend::supernodal : FactorBackend::automatic;
    auto factor =
        std::make_unique<SpdFactor>(FactorOptions{.backend = backend, .ordering = Ordering::natural});
    try {
        factor->factorize(ordered(matrix, order));
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed& failure) {
        if (failure.elements().empty())
            throw;
        const int unknown = order[failure.elements().front()];
        throw FactorizationFailed("the matrix is not positive definite at unknown " + std::to_string(unknown),
                                  Error::Element::vertex, {unknown});
    }
    adopt(std::move(factor), order);
}

void SingleFactor::adopt(std::unique_ptr<SpdFactor> factor)
{
    std::vector<int> order(factor->size());
    std::iota(order.begin(), order.end(), 0);
    adopt(std::move(factor), order);
}

/// \param order  the number that each unknown of the factor has here.
void SingleFactor::adopt(std::unique_ptr<SpdFactor> factor, const std::vector<int>& order)
{
    size_ = factor->size();
    other_.reset();
    supernodal_.reset();
    const std::optional<SupernodalFactor> f = factor->supernodal();
    if (!f) {
        order_ = order;
        other_ = std::move(factor);
        return;
    }
    order_.resize(size_);
    std::transform(f->permutation, f->permutation + size_, order_.begin(), [&](int i) { return order[i]; });
    first_.assign(f->first, f->first + f->supernodes + 1);
    row_begin_.assign(f->row_begin, f->row_begin + f->supernodes + 1);
    block_begin_.assign(f->block_begin, f->block_begin + f->supernodes + 1);
    rows_.assign(f->rows, f->rows + row_begin_.back());
    values_.resize(block_begin_.back() + f->padding);
    parallel_chunks(block_begin_.back(), 1 << 18, [&](int begin, int end) {
        std::transform(f->values + begin, f->values + end, values_.begin() + begin,
                       [](double value) { return static_cast<float>(value); });
    });
    supernodal_ = std::make_unique<SupernodalSolve<float>>(BasicSupernodalFactor<float>{
        .size = size_,
        .supernodes = f->supernodes,
        .permutation = nullptr,
        .first = first_.data(),
        .row_begin = row_begin_.data(),
        .block_begin = block_begin_.data(),
        .rows = rows_.data(),
        .values = values_.data(),
    });
}

template <class Rows>
void SingleFactor::solve_rows(const Rows& rhs, Rows& solution) const
{
    solution.resize(rhs.rows(), rhs.cols());
    if (size_ == 0)
        return;
    if (other_) {
        MatrixX x(size_, rhs.cols());
        for (int i = 0; i < size_; ++i)
            x.row(i) = rhs.row(order_[i]);
        x = other_->solve(x);
        for (int i = 0; i < size_; ++i)
            solution.row(order_[i]) = x.row(i);
        return;
    }
    // The right side is scaled to 1, as near convergence it may be smaller than the least float.
    std::vector<double> peaks((size_ + grain - 1) / grain);
    parallel_chunks(size_, grain, [&](int begin, int end) {
        peaks[begin / grain] = rhs.middleRows(begin, end - begin).cwiseAbs().maxCoeff();
    });
    const double largest = *std::ranges::max_element(peaks);
    if (!(largest > 0)) {
        solution.setZero();
        return;
    }
    const double scale = 1.0 / largest;
    const int k = static_cast<int>(rhs.cols());
    supernodal_->sweep(
        k,
        [&](float* points) {
            parallel_for(
                size_,
                [&](int i) {
                    float* const lane = points + lane_count * static_cast<std::size_t>(i);
                    for (int c = 0; c < lane_count; ++c)
                        lane[c] = c < k ? static_cast<float>(rhs(order_[i], c) * scale) : 0.0f;
                },
                grain);
        },
        [&](const float* points) {
            parallel_for(
                size_,
                [&](int i) {
                    const float* const lane = points + lane_count * static_cast<std::size_t>(i);
                    for (int c = 0; c < k; ++c)
                        solution(order_[i], c) = largest * lane[c];
                },
                grain);
        });
}

void SingleFactor::solve(const Points& rhs, Points& solution) const { solve_rows(rhs, solution); }
void SingleFactor::solve(const MatrixX& rhs, MatrixX& solution) const { solve_rows(rhs, solution); }

void SingleFactor::rename(const std::vector<int>& names)
{
    for (int& unknown : order_)
        unknown = names[unknown];
}

std::int64_t SingleFactor::bytes() const
{
    if (other_)
        return other_->bytes();
    const std::size_t numbers = order_.size() + first_.size() + row_begin_.size() + block_begin_.size() +
                                rows_.size() + values_.size();
    return static_cast<std::int64_t>(4 * numbers);
}

} // namespace sinew
