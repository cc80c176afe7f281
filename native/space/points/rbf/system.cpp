// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/points/rbf/system.h"

#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace sinew {

namespace {

/// What is tried on the diagonal, as shares of the largest value of phi. Centres that are close together make
/// phi singular up to rounding; then they are met in the mean, and others nearly exactly.
constexpr double softnesses[] = {0.0, 1e-9, 1e-7};

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
    require_memory(2 * DenseCholesky::bytes(count_), "the system of radial basis functions");
    progress.tick(0.0, "computing radial functions");
    RowMatrix Phi = rbf_values(basis, centres, centres);
    qr_ = std::make_unique<Eigen::HouseholderQR<MatrixX>>(P);
    // Q^T Phi Q, one reflection I - tau v v^T after the other, from both sides at once.
    for (int k = 0; k < q; ++k) {
        const double tau = qr_->hCoeffs()[k];
        VectorX v = VectorX::Zero(count_);
        v[k] = 1.0;
        v.tail(count_ - k - 1) = qr_->matrixQR().col(k).tail(count_ - k - 1);
        VectorX u(count_);
        parallel_for(count_, [&](int i) { u[i] = tau * Phi.row(i).dot(v); }, 128);
        const VectorX w = u - (0.5 * tau * u.dot(v)) * v;
        parallel_for(count_, [&](int i) { Phi.row(i) -= v[i] * w.transpose() + w[i] * v.transpose(); }, 128);
    }
    beside_ = Phi.topRightCorner(q, free);
    const double largest = free > 0 ? Phi.diagonal().tail(free).maxCoeff() : 0.0;
    for (const double softness : softnesses) {
        dense_ = DenseCholesky(free);
        for (int i = 0; i < free; ++i) {
            std::copy_n(Phi.row(q + i).data() + q + i, free - i, dense_.row(i) + i);
            dense_.row(i)[i] += softness * largest;
        }
        softness_ = softness;
        if (dense_.factorize(progress, "factorising") < 0)
            return;
    }
    throw FactorizationFailed(
        "the system of radial basis functions is singular: handle points are too close");
}

void RbfSystem::factorize_sparse(const Points& centres, const RbfBasis& basis, const RowMatrix& P,
                                 const Progress& progress)
{
    const auto values = widest_kernels<RbfKernels>().values[static_cast<int>(basis.function)];
    constexpr int some = 64; // rows at once
    std::vector<std::vector<Eigen::Triplet<double>>> found(
        static_cast<std::size_t>((count_ + some - 1) / some));
    progress.tick(0.0, "computing radial functions");
    parallel_chunks(count_, some, [&](int begin, int end) {
        std::array<double, 24> eight{};
        std::vector<double> of(8 * static_cast<std::size_t>(count_));
        auto& own = found[static_cast<std::size_t>(begin / some)];
        for (int first = begin; first < end; first += 8) {
            const int last = std::min(first + 8, end);
            for (int k = 0; k < 3; ++k)
                for (int i = first; i < last; ++i)
                    eight[8 * k + (i - first)] = centres(i, k);
            values(centres.data(), last, basis.scale, eight.data(), of.data());
            for (int i = first; i < last; ++i)
                for (int j = 0; j <= i; ++j)
                    if (const double value = of[8 * static_cast<std::size_t>(j) + (i - first)]; value != 0.0)
                        own.emplace_back(i, j, value);
        }
    });
    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& own : found)
        entries.insert(entries.end(), own.begin(), own.end());
    SparseMatrix Phi(count_, count_);
    Phi.setFromTriplets(entries.begin(), entries.end());
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
        schur_ = std::make_unique<Eigen::LDLT<MatrixX>>(MatrixX(P.transpose() * solved_P_));
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
            found.polynomial = schur_->solve(MatrixX(P_.transpose() * found.weights));
            found.weights -= solved_P_ * found.polynomial;
        }
        return found;
    }
    MatrixX turned = values;
    turned.applyOnTheLeft(qr_->householderQ().adjoint());
    RowMatrix y = turned.bottomRows(free);
    dense_.solve(y);
    RbfCoefficients found;
    found.polynomial = turned.topRows(q) - beside_ * y;
    if (q > 0) {
        MatrixX a = found.polynomial;
        qr_->matrixQR().topRows(q).triangularView<Eigen::Upper>().solveInPlace(a);
        found.polynomial = a;
    }
    turned.topRows(q).setZero();
    turned.bottomRows(free) = y;
    turned.applyOnTheLeft(qr_->householderQ());
    found.weights = turned;
    return found;
}

std::int64_t RbfSystem::bytes() const
{
    return sparse_ ? sparse_->bytes() : DenseCholesky::bytes(dense_.size()) + 8 * beside_.size();
}

} // namespace sinew
