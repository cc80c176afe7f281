// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/single_factor.h"

#include "native/core/parallel.h"
#include "native/solvers/cholmod_factor.h"
#include "native/solvers/lanes.h"

#include <algorithm>
#include <numeric>
#include <optional>

namespace sinew {

namespace {

constexpr int grain = 4096;

} // namespace

void SingleFactor::factorize(const SparseMatrix& matrix, Ordering ordering)
{
    const auto backend = have_cholmod() ? FactorBackend::supernodal : FactorBackend::automatic;
    auto factor = std::make_unique<SpdFactor>(FactorOptions{.backend = backend, .ordering = ordering});
    factor->factorize(matrix);
    size_ = factor->size();
    other_.reset();
    supernodal_.reset();
    const std::optional<SupernodalFactor> f = factor->supernodal();
    if (!f) {
        order_.resize(size_);
        std::iota(order_.begin(), order_.end(), 0);
        other_ = std::move(factor);
        return;
    }
    order_.assign(f->permutation, f->permutation + size_);
    first_.assign(f->first, f->first + f->supernodes + 1);
    row_begin_.assign(f->row_begin, f->row_begin + f->supernodes + 1);
    block_begin_.assign(f->block_begin, f->block_begin + f->supernodes + 1);
    rows_.assign(f->rows, f->rows + row_begin_.back());
    values_.resize(block_begin_.back());
    std::transform(f->values, f->values + values_.size(), values_.begin(),
                   [](double value) { return static_cast<float>(value); });
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
        solution = other_->solve(rhs);
        return;
    }
    // Scaled to 1: a right side near convergence would fall below the least float.
    const double largest = rhs.cwiseAbs().maxCoeff();
    if (!(largest > 0)) {
        solution.setZero();
        return;
    }
    const double scale = 1.0 / largest;
    const int k = static_cast<int>(rhs.cols());
    const std::unique_ptr<float[]> lanes(new float[static_cast<std::size_t>(size_) * lane_count]);
    parallel_for(
        size_,
        [&](int i) {
            float* const lane = lanes.get() + lane_count * static_cast<std::size_t>(i);
            for (int c = 0; c < lane_count; ++c)
                lane[c] = c < k ? static_cast<float>(rhs(order_[i], c) * scale) : 0.0f;
        },
        grain);
    supernodal_->sweep(lanes.get());
    parallel_for(
        size_,
        [&](int i) {
            const float* const lane = lanes.get() + lane_count * static_cast<std::size_t>(i);
            for (int c = 0; c < k; ++c)
                solution(order_[i], c) = largest * lane[c];
        },
        grain);
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
