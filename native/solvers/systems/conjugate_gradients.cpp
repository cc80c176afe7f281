// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/systems/conjugate_gradients.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/solvers/systems/not_converged.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>

namespace sinew {

namespace {

using Eigen::Array4d;

constexpr int grain = 2048;
constexpr double singular = 1e-14; ///< a smallest eigenvalue below this share of the largest is rounding
constexpr double slowest = 0.02;   ///< what an error loses in a step where it hardly shrinks
constexpr double cautious = 4; ///< times the share that corrections leave counts for the last one
constexpr double endless = 1e8;    ///< growth of what the tolerance is compared with

/// Two sums and a largest value over the unknowns, by columns.
struct Sums
{
    Array4d first = Array4d::Zero(), second = Array4d::Zero(), largest = Array4d::Zero();
};

/// body(i, sums) adds to the sums, in an order that does not depend on the threads.
template <class Body>
Sums gather(int count, Body&& body)
{
    std::vector<Sums> parts((count + grain - 1) / grain);
    parallel_chunks(count, grain, [&](int begin, int end) {
        Sums sums;
        for (int i = begin; i < end; ++i)
            body(i, sums);
        parts[begin / grain] = sums;
    });
    Sums total;
    for (const Sums& part : parts) {
        total.first += part.first;
        total.second += part.second;
        total.largest = total.largest.max(part.largest);
    }
    return total;
}

Array4d row_times(const SparseMatrix& A, int i, const Columns& x)
{
    Array4d sum = Array4d::Zero();
    for (SparseMatrix::InnerIterator it(A, i); it; ++it)
        sum += it.value() * x[it.row()];
    return sum;
}

Array4d ratio(const Array4d& a, const Array4d& b) { return (b > 0).select(a / (b > 0).select(b, 1.0), 0.0); }

/// The least and the largest eigenvalue of the matrix that the coefficients of one column make.
std::pair<double, double> ritz_values(const std::vector<double>& alpha, const std::vector<double>& beta)
{
    const auto n = static_cast<Eigen::Index>(alpha.size());
    if (n == 0)
        return {1.0, 1.0};
    VectorX diagonal(n), beside(std::max<Eigen::Index>(n - 1, 0));
    for (Eigen::Index k = 0; k < n; ++k) {
        diagonal[k] = 1.0 / alpha[k] + (k > 0 ? beta[k - 1] / alpha[k - 1] : 0.0);
        if (k + 1 < n)
            beside[k] = std::sqrt(std::max(beta[k], 0.0)) / alpha[k];
    }
    Eigen::SelfAdjointEigenSolver<MatrixX> eigen;
    eigen.computeFromTridiagonal(diagonal, beside, Eigen::EigenvaluesOnly);
    return {eigen.eigenvalues().minCoeff(), eigen.eigenvalues().maxCoeff()};
}

} // namespace

Iteration conjugate_gradients(const SparseMatrix& A, const Columns& b, Columns& x, const Preconditioner& B,
                              const Stop& stop, const Progress& progress)
{
    const int n = static_cast<int>(A.cols());
    Columns r(n);
    const Array4d load = gather(n, [&](int i, Sums& sums) {
                             r[i] = b[i] - row_times(A, i, x);
                             sums.first += b[i].square();
                         }).first;
    const auto multiply = [&](const Columns& from, Columns& to) {
        parallel_for(n, [&](int i) { to[i] = row_times(A, i, from); }, grain);
    };
    return conjugate_gradients(n, multiply, load.sqrt(), r, x, B, stop, progress);
}

Iteration conjugate_gradients(int n, const Product& A, const Array4d& load, Columns& r, Columns& x,
                              const Preconditioner& B, const Stop& stop, const Progress& progress)
{
    Columns z(r.size(), Array4d(Array4d::Zero())), p = z, q = z;
    Iteration done;
    std::array<std::vector<double>, 4> alphas, betas;
    Array4d rz = Array4d::Zero(), alpha = Array4d::Zero();
    const bool corrected = stop.measure == Measure::corrected;
    const bool remaining = corrected || stop.measure == Measure::remaining;
    double first = 0.0;
    for (;; ++done.count) {
        B(r, z);
        const Sums after = gather(n, [&](int i, Sums& sums) {
            sums.first += r[i] * z[i];
            sums.second += z[i] * q[i];
            sums.largest = sums.largest.max(z[i].abs());
        });
        const Sums sizes = gather(n, [&](int i, Sums& sums) {
            sums.first += r[i].square();
            sums.largest = sums.largest.max(x[i].abs());
        });
        if (!after.first.isFinite().all() || !sizes.first.isFinite().all())
            throw NotConverged("the iteration diverges: its numbers were no longer finite at iteration " +
                               std::to_string(done.count));
        Array4d wanted = stop.tolerance * load, found = sizes.first.sqrt();
        if (stop.measure != Measure::residual) {
            wanted = stop.tolerance * sizes.largest.max(after.largest);
            found = after.largest;
            if (remaining) {
                wanted = wanted.maxCoeff();
                const double share = found.maxCoeff() / wanted[0] * stop.tolerance / first;
                if (done.count > 0) {
                    const double rate = std::pow(share, 1.0 / done.count);
                    found *= (corrected ? std::min(cautious * rate, 1.0) : 1.0) / std::max(1 - rate, slowest);
                }
            }
        }
        const auto busy = (load > 0) && (found > wanted);
        done.reached = (load > 0).select(found / wanted.max(1e-300), 0.0).maxCoeff() * stop.tolerance;
        if (!busy.any()) {
            done.converged = true;
            if (remaining)
                parallel_for(n, [&](int i) { x[i] += z[i]; }, grain);
            break;
        }
        if ((busy && after.first < 0).any())
            throw FactorizationFailed("the preconditioner is not positive definite");
        first = done.count == 0 ? done.reached : first;
        if (done.reached > endless * std::max(first, stop.tolerance))
            throw NotConverged("the iteration diverges: after " + std::to_string(done.count) +
                               " iterations it was farther from the solution than at first");
        if (done.count == stop.most_iterations)
            break;
        const double way = std::log(first / stop.tolerance), gone = std::log(first / done.reached);
        progress.tick(remaining ? std::clamp(gone / way, 0.0, 1.0)
                                : static_cast<double>(done.count) / stop.most_iterations,
                      "iterating");
        // r_k . z_k+1 = r_k+1 . z_k+1 + alpha q_k . z_k+1
        const Array4d beta =
            done.count > 0 ? ratio(-alpha * after.second, rz).max(0.0) : Array4d(Array4d::Zero());
        rz = after.first;
        parallel_for(n, [&](int i) { p[i] = z[i] + beta * p[i]; }, grain);
        A(p, q);
        const Array4d energy = gather(n, [&](int i, Sums& sums) { sums.first += p[i] * q[i]; }).first;
        if ((busy && energy <= 0).any())
            throw FactorizationFailed("the matrix is not positive definite: p^T A p <= 0 at iteration " +
                                      std::to_string(done.count));
        alpha = busy.select(ratio(rz, energy), 0.0);
        parallel_for(
            n,
            [&](int i) {
                x[i] += alpha * p[i];
                r[i] -= alpha * q[i];
            },
            grain);
        for (int c = 0; c < 4; ++c)
            if (alpha[c] > 0) {
                if (!alphas[c].empty())
                    betas[c].push_back(beta[c]);
                alphas[c].push_back(alpha[c]);
            }
    }
    done.least = std::numeric_limits<double>::infinity();
    for (int c = 0; c < 4; ++c)
        if (!alphas[c].empty()) {
            const auto [least, most] = ritz_values(alphas[c], betas[c]);
            done.least = std::min(done.least, least);
            done.most = std::max(done.most, most);
        }
    if (!std::isfinite(done.least))
        done.least = done.most = 1.0;
    if (!done.converged && done.least < singular * done.most)
        throw FactorizationFailed("the matrix is singular: its smallest eigenvalue is 0 up to rounding");
    return done;
}

double norm_of(int size, const std::function<VectorX(const VectorX&)>& map, int steps)
{
    std::mt19937 random(1); // NOLINT(bugprone-random-generator-seed): the same in each call
    VectorX v(size);
    for (int i = 0; i < size; ++i)
        v[i] = static_cast<double>(random()) / 2147483648.0 - 1.0;
    const int count = std::min(steps, size);
    MatrixX basis(size, count);
    VectorX diagonal = VectorX::Zero(count), beside = VectorX::Zero(count);
    int k = 0;
    v.normalize();
    for (; k < count; ++k) {
        basis.col(k) = v;
        VectorX w = map(v);
        diagonal[k] = v.dot(w);
        for (int pass = 0; pass < 2; ++pass)
            for (int j = 0; j <= k; ++j)
                w -= basis.col(j).dot(w) * basis.col(j);
        beside[k] = w.norm();
        if (!(beside[k] > 1e-12 * std::abs(diagonal[0])))
            break;
        v = w / beside[k];
    }
    k = std::min(k + 1, count);
    Eigen::SelfAdjointEigenSolver<MatrixX> eigen;
    eigen.computeFromTridiagonal(diagonal.head(k), beside.head(std::max(k - 1, 0)), Eigen::EigenvaluesOnly);
    return eigen.eigenvalues().cwiseAbs().maxCoeff();
}

} // namespace sinew
