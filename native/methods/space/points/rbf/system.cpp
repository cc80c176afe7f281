// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/points/rbf/system.h"

#include "native/core/dense.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/simd/aligned.h"
#include "native/core/simd/kernel_set.h"
#include "native/methods/space/points/rbf/near_centres.h"
#include "native/solvers/dense/kernels.h"
#include "native/solvers/dense/system.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>
#include <vector>

namespace sinew {

namespace {

/// What is tried on the diagonal, as shares of the largest value of phi. Centres that are close together make
/// phi singular up to rounding; then they are met in the mean, and others nearly exactly.
constexpr double softnesses[] = {0.0, 1e-9, 1e-7};

/// The lower triangle of phi of a compact function at the centres themselves.
SparseMatrix near_values(const Points& centres, const RbfBasis& basis)
{
    const auto values = widest_kernels<RbfKernels>().values[static_cast<int>(basis.function)];
    const NearCentres near(centres, 1.0 / basis.scale);
    const int count = static_cast<int>(centres.rows());
    std::vector<std::vector<std::pair<int, double>>> columns(static_cast<std::size_t>(count));
    std::atomic<std::int64_t> total = 0;
    parallel_chunks(count, 8, [&](int first, int last) {
        const auto some = near.centres().middleRows(first, last - first);
        std::array<double, 24> eight{};
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < last - first; ++i)
                eight[8 * k + i] = some(i, k);
        std::vector<double> found;
        near.visit(some.colwise().minCoeff(), some.colwise().maxCoeff(), [&](int begin, int end) {
            found.resize(8 * static_cast<std::size_t>(end - begin));
            values(near.centres().row(begin).data(), end - begin, basis.scale, eight.data(), found.data());
            for (int j = begin; j < end; ++j)
                for (int i = first; i < last; ++i)
                    if (const double value = found[8 * static_cast<std::size_t>(j - begin) + (i - first)];
                        value != 0.0 && near.order()[j] >= near.order()[i])
                        columns[near.order()[i]].emplace_back(near.order()[j], value);
        });
        std::int64_t own = 0;
        for (int i = first; i < last; ++i) {
            auto& column = columns[near.order()[i]];
            std::ranges::sort(column);
            own += static_cast<std::int64_t>(column.size());
        }
        require_memory(32 * (total += own), "the matrix of radial functions");
    });
    SparseMatrix Phi(count, count);
    Phi.reserve(static_cast<Eigen::Index>(total));
    for (int i = 0; i < count; ++i) {
        Phi.startVec(i);
        for (const auto& [row, value] : columns[i])
            Phi.insertBack(row, i) = value;
    }
    Phi.finalize();
    return Phi;
}

} // namespace

RowMatrix rbf_values(const RbfBasis& basis, const Points& points, const Points& centres)
{
    const auto values = widest_kernels<RbfKernels>().values[static_cast<int>(basis.function)];
    const int n = static_cast<int>(points.rows()), c = static_cast<int>(centres.rows());
    RowMatrix all(n, c);
    parallel_chunks(n, 8, [&](int begin, int end) {
        std::array<double, 24> eight{};
        std::vector<double> found(8 * static_cast<std::size_t>(c));
        for (int k = 0; k < 3; ++k)
            for (int i = begin; i < end; ++i)
                eight[8 * k + (i - begin)] = points(i, k);
        values(centres.data(), c, basis.scale, eight.data(), found.data());
        for (int i = begin; i < end; ++i)
            for (int j = 0; j < c; ++j)
                all(i, j) = found[8 * static_cast<std::size_t>(j) + (i - begin)];
    });
    return all;
}

RowMatrix rbf_sums(const RbfBasis& basis, const Points& points, const Points& centres,
                   const RowMatrix& weights)
{
    constexpr int some = 256; // centres, whose values stay in the cache
    const auto values = widest_kernels<RbfKernels>().values[static_cast<int>(basis.function)];
    const auto add_product = widest_kernels<DenseKernels>().add_product;
    const int n = static_cast<int>(points.rows()), c = static_cast<int>(centres.rows()),
              columns = static_cast<int>(weights.cols()), strips = (columns + strip_width - 1) / strip_width;
    AlignedVector<double> packed(static_cast<std::size_t>(strips) * c * strip_width, 0.0);
    for (int k = 0; k < columns; ++k)
        for (int j = 0; j < c; ++j)
            packed[(static_cast<std::size_t>(k / strip_width) * c + j) * strip_width + k % strip_width] =
                weights(j, k);
    RowMatrix sums(n, columns);
    parallel_chunks(n, 8, [&](int begin, int end) {
        std::array<double, 24> eight{};
        for (int k = 0; k < 3; ++k)
            for (int i = begin; i < end; ++i)
                eight[8 * k + (i - begin)] = points(i, k);
        AlignedVector<double> found(8 * some), own(static_cast<std::size_t>(8 * strips) * strip_width, 0.0);
        for (int first = 0; first < c; first += some) {
            const int count = std::min(some, c - first);
            values(centres.row(first).data(), count, basis.scale, eight.data(), found.data());
            for (int s = 0; s < strips; ++s)
                add_product(found.data(), 1, 8, 8, count,
                            packed.data() + (static_cast<std::size_t>(s) * c + first) * strip_width, 1,
                            own.data() + s * strip_width, strips * strip_width, nullptr);
        }
        for (int i = begin; i < end; ++i)
            for (int k = 0; k < columns; ++k)
                sums(i, k) = own[static_cast<std::size_t>(i - begin) * strips * strip_width + k];
    });
    return sums;
}

RbfSystem::RbfSystem(const Points& centres, const RbfBasis& basis, const Polynomials& polynomials,
                     const Progress& progress)
    : count_(static_cast<int>(centres.rows())), polynomials_(polynomials.count())
{
    const RowMatrix P = polynomials.evaluate(centres);
    if (is_compact(basis.function))
        factorize_sparse(centres, basis, P, progress);
    else
        factorize_dense(centres, basis, P, progress);
}

void RbfSystem::factorize_dense(const Points& centres, const RbfBasis& basis, const RowMatrix& P,
                                const Progress& progress)
{
    const int q = polynomials_, free = count_ - q;
    progress.tick(0.0, "computing radial functions");
    base_ = LagrangeBase(P);
    Points z(q, 3), places(free, 3);
    std::vector<char> in_base(static_cast<std::size_t>(count_), 0);
    for (int k = 0; k < q; ++k) {
        in_base[static_cast<std::size_t>(base_.points[k])] = 1;
        z.row(k) = centres.row(base_.points[k]);
    }
    for (int i = 0; i < count_; ++i)
        if (!in_base[static_cast<std::size_t>(i)]) {
            places.row(static_cast<Eigen::Index>(others_.size())) = centres.row(i);
            others_.push_back(i);
        }
    at_base_ = rbf_values(basis, centres, z);
    MatrixX lagrange(free, q), half(free, q), at_z(q, q);
    for (int k = 0; k < q; ++k)
        at_z.row(k) = at_base_.row(base_.points[k]);
    for (int i = 0; i < free; ++i) {
        lagrange.row(i) = base_.lagrange.row(others_[i]);
        half.row(i) = at_base_.row(others_[i]);
    }
    half -= product(0.5 * lagrange, at_z);
    for (const double softness : softnesses) {
        dense_ = DenseCholesky(free);
        fill(places, basis, lagrange, half);
        double largest = 0.0;
        for (int i = 0; i < free; ++i)
            largest = std::max(largest, dense_.row(i)[i]);
        for (int i = 0; i < free; ++i)
            dense_.row(i)[i] += softness * largest;
        softness_ = softness;
        if (dense_.factorize(progress, "factorising") < 0)
            return;
    }
    throw FactorizationFailed(
        "the system of radial basis functions is singular: handle points are too close");
}

/// psi at the upper triangle: phi - L half^T - half L^T.
void RbfSystem::fill(const Points& others, const RbfBasis& basis, const MatrixX& lagrange,
                     const MatrixX& half)
{
    const auto values = widest_kernels<RbfKernels>().values[static_cast<int>(basis.function)];
    const int free = static_cast<int>(others.rows()), q = static_cast<int>(lagrange.cols());
    // What is subtracted is a product of (free, 2 q) with (2 q, free).
    RowMatrix left(free, 2 * q), right(2 * q, free);
    left << -lagrange, -half;
    right << half.transpose(), lagrange.transpose();
    const PackedColumns packed(right.data(), 2 * q, free, static_cast<std::size_t>(free));
    parallel_chunks(free, 8, [&](int begin, int end) {
        std::array<double, 24> eight{};
        std::vector<double> found(8 * static_cast<std::size_t>(free - begin));
        for (int k = 0; k < 3; ++k)
            for (int i = begin; i < end; ++i)
                eight[8 * k + (i - begin)] = others(i, k);
        values(others.data() + 3 * static_cast<std::size_t>(begin), free - begin, basis.scale, eight.data(),
               found.data());
        for (int i = begin; i < end; ++i)
            for (int j = begin; j < free; ++j)
                dense_.row(i)[j] = found[8 * static_cast<std::size_t>(j - begin) + (i - begin)];
        const int stride = static_cast<int>(dense_.row(1) - dense_.row(0));
        if (q > 0)
            packed.multiply_add(left.row(begin).data(), 2 * q, end - begin, dense_.row(begin), stride);
    });
}

void RbfSystem::factorize_sparse(const Points& centres, const RbfBasis& basis, const RowMatrix& P,
                                 const Progress& progress)
{
    progress.tick(0.0, "computing radial functions");
    SparseMatrix Phi = near_values(centres, basis);
    progress.tick(0.3, "factorising");
    for (const double softness : softnesses) {
        sparse_ = std::make_unique<SpdFactor>();
        softness_ = softness;
        for (int i = 0; i < count_; ++i)
            Phi.coeffRef(i, i) = 1.0 + softness;
        try {
            sparse_->factorize(Phi);
            break;
        } catch (const OutOfMemory&) {
            throw;
        } catch (const FactorizationFailed&) {
            if (softness == softnesses[std::size(softnesses) - 1])
                throw FactorizationFailed(
                    "the system of radial basis functions is singular: handle points are too close");
        }
    }
    if (polynomials_ > 0) {
        P_ = P;
        solved_P_ = P;
        sparse_->solve_rows(solved_P_);
        schur_ = std::make_unique<Eigen::LDLT<MatrixX>>(transposed_product(P, solved_P_));
    }
    progress.tick(1.0, "factorising");
}

RbfCoefficients RbfSystem::solve(const RowMatrix& values) const
{
    const int q = polynomials_, free = count_ - q;
    if (sparse_) {
        RbfCoefficients found{values, RowMatrix(0, values.cols())};
        sparse_->solve_rows(found.weights);
        if (schur_) {
            found.polynomial = schur_->solve(transposed_product(P_, found.weights));
            found.weights -= product(solved_P_, found.polynomial);
        }
        return found;
    }
    MatrixX at_z(q, values.cols());
    for (int k = 0; k < q; ++k)
        at_z.row(k) = values.row(base_.points[k]);
    const RowMatrix left = values - product(base_.lagrange, at_z);
    RowMatrix y(free, values.cols());
    for (int i = 0; i < free; ++i)
        y.row(i) = left.row(others_[i]);
    dense_.solve(y);
    RbfCoefficients found;
    found.weights = RowMatrix::Zero(count_, values.cols());
    for (int i = 0; i < free; ++i)
        found.weights.row(others_[i]) = y.row(i);
    const MatrixX sum = transposed_product(base_.lagrange, found.weights);
    for (int k = 0; k < q; ++k)
        found.weights.row(base_.points[k]) = -sum.row(k);
    found.polynomial = product(base_.inverse, at_z - transposed_product(at_base_, found.weights));
    return found;
}

std::int64_t RbfSystem::bytes() const
{
    return sparse_ ? sparse_->bytes() : DenseCholesky::bytes(dense_.size()) + 8 * at_base_.size();
}

} // namespace sinew
