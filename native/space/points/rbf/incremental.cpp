// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/points/rbf/incremental.h"

#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/solvers/dense/kernels.h"
#include "native/solvers/dense/system.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace sinew {

namespace {

/// So many points are fitted at first.
constexpr int first_points = 8000;
/// So many of those that are missed join them at once.
constexpr int most_missed = 4000;
/// Centres that are added at first; later more, in proportion to those so far.
constexpr int first_block = 16;
constexpr int largest_block = 96;
constexpr int tile = 48; ///< rows that one thread takes at once
/// A centre whose function is, up to this share, a sum of those before it adds nothing.
constexpr double least_pivot = 1e-13;

int padded(int columns) { return (columns + strip_width - 1) / strip_width * strip_width; }

/// The function as a sum over centres, which gains centres block by block.
class Sum
{
public:
    Sum(const Points& points, const RowMatrix& values, const RbfBasis& basis, const Polynomials& polynomials)
        : points_(points), values_(values), basis_(basis), base_(polynomials.evaluate(points)),
          columns_(static_cast<int>(values.cols()))
    {
        const auto q = static_cast<Eigen::Index>(base_.points.size());
        Points z(q, 3);
        MatrixX at_z(q, q), of_z(q, columns_);
        for (Eigen::Index k = 0; k < q; ++k)
            z.row(k) = points.row(base_.points[k]);
        at_base_ = rbf_values(basis, points, z);
        for (Eigen::Index k = 0; k < q; ++k) {
            at_z.row(k) = at_base_.row(base_.points[k]);
            of_z.row(k) = values.row(base_.points[k]);
        }
        const RowMatrix lagrange = base_.lagrange, half = at_base_ - 0.5 * lagrange * at_z;
        left_.resize(points.rows(), 2 * q);
        left_ << -lagrange, -half;
        right_.resize(points.rows(), 2 * q);
        right_ << half, lagrange;
        residuals_ = RowMatrix::Zero(points.rows(), padded(columns_));
        residuals_.leftCols(columns_) = values - lagrange * of_z;
        is_row_.assign(static_cast<std::size_t>(points.rows()), 0);
        for (const int point : base_.points)
            is_row_[static_cast<std::size_t>(point)] = 1; // they are met by the polynomials
    }

    bool is_row(int point) const { return is_row_[static_cast<std::size_t>(point)] != 0; }
    int centre_count() const { return done_; }

    /// Takes more points into the fit.
    void add(const std::vector<int>& points)
    {
        const int old = row_count();
        for (const int point : points) {
            is_row_[static_cast<std::size_t>(point)] = 1;
            rows_.push_back(point);
            distances_.push_back(1.0);
            is_dropped_.push_back(0);
        }
        parallel_for(
            row_count() - old,
            [&](int i) {
                double& nearest = distances_[old + i];
                for (const int point : base_.points)
                    nearest = std::min(nearest, distance(rows_[old + i], point));
                for (int c = 0; c < done_; ++c)
                    nearest = std::min(nearest, distance(rows_[old + i], rows_[c]));
            },
            16);
        for (std::size_t b = 0; b < blocks_.size(); ++b) {
            Block& block = blocks_[b];
            RowMatrix N = remainder(old, block.begin, block.count, b);
            divide(block, N, 0);
            block.N.conservativeResize(row_count() - block.begin, Eigen::NoChange);
            block.N.bottomRows(row_count() - old) = N;
            subtract_from_residuals(block, old);
        }
    }

    /// The largest residual of a row.
    double error() const
    {
        double most = 0.0;
        for (int i = done_; i < row_count(); ++i)
            most = std::max(most, residual(i));
        return most;
    }

    /// Makes up to so many more rows centres. \return whether there are any.
    bool extend(int count)
    {
        count = choose(count);
        if (count == 0)
            return false;
        RowMatrix N = remainder(done_, done_, count, blocks_.size());
        // A Cholesky factor of the square at the top, without the columns that the others make up.
        MatrixX L = MatrixX::Zero(count, count); // rows in the order of the chosen ones
        std::vector<int> kept;
        for (int j = 0; j < count; ++j) {
            const auto k = static_cast<Eigen::Index>(kept.size());
            const int point = rows_[done_ + j];
            const double whole = 2.0 * left_.row(point)
                                           .head(right_.cols() / 2)
                                           .dot(right_.row(point).head(right_.cols() / 2)),
                         pivot = N(j, j) - L.row(j).head(k).squaredNorm();
            if (!(pivot > least_pivot * std::abs(whole))) {
                is_dropped_[done_ + j] = 1;
                continue;
            }
            kept.push_back(j);
            L(j, k) = std::sqrt(pivot);
            for (int i = j + 1; i < count; ++i)
                L(i, k) = (N(i, j) - L.row(i).head(k).dot(L.row(j).head(k))) / L(j, k);
        }
        Block block{done_, static_cast<int>(kept.size()), {}, {}, {}};
        for (int k = 0; k < block.count; ++k) // those that are left out go below the others
            if (kept[k] != k) {
                swap_rows(done_ + k, done_ + kept[k]);
                N.row(k).swap(N.row(kept[k]));
                L.row(k).swap(L.row(kept[k]));
                N.col(k) = N.col(kept[k]).eval();
            }
        if (block.count == 0)
            return true; // others may do
        N.conservativeResize(Eigen::NoChange, padded(block.count));
        N.rightCols(N.cols() - block.count).setZero();
        block.upper = L.topLeftCorner(block.count, block.count).transpose();
        block.N = std::move(N);
        divide(block, block.N, block.count);
        block.N.topRows(block.count).setZero();
        block.N.topLeftCorner(block.count, block.count) = block.upper.transpose();
        const std::vector<int> own(rows_.begin() + done_, rows_.begin() + done_ + block.count);
        block.y = residuals_(own, Eigen::all);
        residuals_(own, Eigen::all).setZero();
        block.upper.transpose().triangularView<Eigen::Lower>().solveInPlace(block.y);
        subtract_from_residuals(block, done_ + block.count);
        done_ += block.count;
        held_ += 8 * static_cast<std::int64_t>(block.N.size());
        blocks_.push_back(std::move(block));
        require_memory(held_, "the fit of radial basis functions");
        return true;
    }

    RbfFit fit() const
    {
        // w = L^-T y, from the last block to the first.
        const auto q = static_cast<Eigen::Index>(base_.points.size());
        RbfFit fit{Points(done_ + q, 3), {RowMatrix::Zero(done_ + q, columns_), RowMatrix(q, columns_)}, 0.0};
        RowMatrix& w = fit.coefficients.weights;
        for (std::size_t b = blocks_.size(); b-- > 0;) {
            const Block& block = blocks_[b];
            const int end = block.begin + block.count;
            MatrixX y = block.y.leftCols(columns_);
            y.noalias() -= block.N.block(block.count, 0, done_ - end, block.count).transpose() *
                           w.middleRows(end, done_ - end);
            block.upper.triangularView<Eigen::Upper>().solveInPlace(y);
            w.middleRows(block.begin, block.count) = y;
        }
        MatrixX at_z(q, columns_), phi_z = MatrixX::Zero(q, columns_);
        for (int c = 0; c < done_; ++c) {
            fit.centres.row(c) = points_.row(rows_[c]);
            w.bottomRows(q) -= base_.lagrange.row(rows_[c]).transpose() * w.row(c);
        }
        for (int c = 0; c < done_; ++c)
            phi_z += at_base_.row(rows_[c]).transpose() * w.row(c);
        for (Eigen::Index k = 0; k < q; ++k) {
            fit.centres.row(done_ + k) = points_.row(base_.points[k]);
            at_z.row(k) = values_.row(base_.points[k]);
            phi_z += at_base_.row(base_.points[k]).transpose() * w.row(done_ + k);
        }
        fit.coefficients.polynomial = base_.inverse * (at_z - phi_z);
        return fit;
    }

private:
    /// Some centres, which are the rows from `begin` on.
    struct Block
    {
        int begin, count;
        RowMatrix N;     ///< (rows from `begin` on, padded count) their part of the Newton basis
        RowMatrix upper; ///< (count, count) the transpose of its rows at the centres themselves
        RowMatrix y;     ///< (count, padded columns) what the basis is multiplied with
    };

    int row_count() const { return static_cast<int>(rows_.size()); }
    double distance(int a, int b) const { return (points_.row(a) - points_.row(b)).norm(); }
    double residual(int row) const { return residuals_.row(rows_[row]).cwiseAbs().sum(); }

    /// Moves rows of the largest residual times distance from the centres so far behind these.
    int choose(int count)
    {
        std::vector<double> sizes(rows_.size());
        for (int i = done_; i < row_count(); ++i)
            sizes[i] = residual(i);
        int found = 0;
        for (int last = -1; found < count; ++found) {
            int best = -1;
            double most = 0.0;
            for (int i = done_ + found; i < row_count(); ++i) {
                if (last >= 0)
                    distances_[i] = std::min(distances_[i], distance(rows_[i], last));
                if (const double score = sizes[i] * distances_[i]; score > most && is_dropped_[i] == 0) {
                    most = score;
                    best = i;
                }
            }
            if (best < 0)
                break;
            last = rows_[best];
            swap_rows(best, done_ + found);
            std::swap(sizes[best], sizes[done_ + found]);
        }
        if (found > 0) // the last one counts from the next block on
            for (int i = done_ + found; i < row_count(); ++i)
                distances_[i] = std::min(distances_[i], distance(rows_[i], rows_[done_ + found - 1]));
        return found;
    }

    void swap_rows(int i, int j)
    {
        if (i == j)
            return;
        std::swap(rows_[i], rows_[j]);
        std::swap(distances_[i], distances_[j]);
        std::swap(is_dropped_[i], is_dropped_[j]);
        for (Block& block : blocks_)
            block.N.row(i - block.begin).swap(block.N.row(j - block.begin));
    }

    /// psi of the rows from `first` on at some centres, less what the first blocks explain of it.
    RowMatrix remainder(int first, int centre, int count, std::size_t blocks) const
    {
        Points places(count, 3), own(row_count() - first, 3);
        RowMatrix of_left(own.rows(), left_.cols()), of_right(right_.cols(), count);
        for (int c = 0; c < count; ++c) {
            places.row(c) = points_.row(rows_[centre + c]);
            of_right.col(c) = right_.row(rows_[centre + c]).transpose();
        }
        for (int i = first; i < row_count(); ++i) {
            own.row(i - first) = points_.row(rows_[i]);
            of_left.row(i - first) = left_.row(rows_[i]);
        }
        RowMatrix A = RowMatrix::Zero(own.rows(), padded(count));
        A.leftCols(count) = rbf_values(basis_, own, places);
        const PackedColumns polynomial(of_right.data(), static_cast<int>(of_right.rows()), count,
                                       static_cast<std::size_t>(count));
        std::vector<PackedColumns> packed;
        for (std::size_t b = 0; b < blocks; ++b) {
            const Block& block = blocks_[b];
            const RowMatrix turned = block.N.middleRows(centre - block.begin, count).transpose();
            packed.emplace_back(turned.data(), static_cast<int>(turned.rows()), count,
                                static_cast<std::size_t>(count), -1.0);
        }
        const auto stride = static_cast<int>(A.cols());
        parallel_chunks(static_cast<int>(A.rows()), tile, [&](int begin, int end) {
            double* const to = A.row(begin).data();
            if (of_left.cols() > 0)
                polynomial.multiply_add(of_left.row(begin).data(), static_cast<int>(of_left.cols()),
                                        end - begin, to, stride);
            for (std::size_t b = 0; b < blocks; ++b) {
                const RowMatrix& N = blocks_[b].N;
                packed[b].multiply_add(N.row(first + begin - blocks_[b].begin).data(),
                                       static_cast<int>(N.cols()), end - begin, to, stride);
            }
        });
        return A;
    }

    /// The rows of A from `first` on times L^-T.
    static void divide(const Block& block, RowMatrix& A, int first)
    {
        const int count = block.count;
        parallel_chunks(static_cast<int>(A.rows()) - first, tile, [&](int begin, int end) {
            RowMatrix some = RowMatrix::Zero(count, padded(end - begin));
            some.leftCols(end - begin) = A.block(first + begin, 0, end - begin, count).transpose();
            widest_kernels<DenseKernels>().substitute(block.upper.data(), count, count, some.data(),
                                                      static_cast<int>(some.cols()),
                                                      static_cast<int>(some.cols()) / strip_width);
            A.block(first + begin, 0, end - begin, count) = some.leftCols(end - begin).transpose();
        });
    }

    /// Of the rows from `first` on.
    void subtract_from_residuals(const Block& block, int first)
    {
        const PackedColumns y(block.y.data(), block.count, columns_, static_cast<std::size_t>(block.y.cols()),
                              -1.0);
        std::vector<int> places(rows_.begin() + first, rows_.end());
        parallel_chunks(row_count() - first, tile, [&](int begin, int end) {
            y.multiply_add(block.N.row(first + begin - block.begin).data(), static_cast<int>(block.N.cols()),
                           end - begin, residuals_.data(), static_cast<int>(residuals_.cols()),
                           places.data() + begin);
        });
    }

    const Points& points_;
    const RowMatrix& values_;
    RbfBasis basis_;
    LagrangeBase base_;
    int columns_, done_ = 0; ///< rows that are centres: the first ones
    RowMatrix at_base_, left_, right_; ///< psi = phi + left right^T
    RowMatrix residuals_; ///< (m, padded columns) in the order of the points
    std::vector<int> rows_; ///< the points of the fit
    std::vector<double> distances_; ///< of the rows from the nearest centre
    std::vector<char> is_row_, is_dropped_;
    std::vector<Block> blocks_;
    std::int64_t held_ = 0;
};

/// The points without a row that a fit misses, the worst ones first.
std::vector<int> missed(const Sum& sum, const RbfFit& fit, const Points& points, const RowMatrix& values,
                        const RbfBasis& basis, const Polynomials& polynomials, double tolerance)
{
    std::vector<double> residuals(static_cast<std::size_t>(points.rows()), 0.0);
    parallel_chunks(static_cast<int>(points.rows()), 256, [&](int begin, int end) {
        std::vector<int> own;
        for (int i = begin; i < end; ++i)
            if (!sum.is_row(i))
                own.push_back(i);
        const Points places = points(own, Eigen::all);
        const RowMatrix left = values(own, Eigen::all) -
                               polynomials.evaluate(places) * fit.coefficients.polynomial -
                               rbf_values(basis, places, fit.centres) * fit.coefficients.weights;
        for (std::size_t k = 0; k < own.size(); ++k)
            residuals[own[k]] = left.row(static_cast<Eigen::Index>(k)).cwiseAbs().sum();
    });
    std::vector<int> all;
    for (int i = 0; i < points.rows(); ++i)
        if (residuals[i] > tolerance)
            all.push_back(i);
    std::ranges::stable_sort(all, std::greater<>(), [&](int i) { return residuals[i]; });
    all.resize(std::min<std::size_t>(all.size(), most_missed));
    return all;
}

} // namespace

RbfFit fit_incrementally(const Points& points, const RowMatrix& values, const RbfBasis& basis,
                         const Polynomials& polynomials, double tolerance, const Progress& progress)
{
    const int m = static_cast<int>(points.rows()), first = std::min(m, first_points);
    Sum sum(points, values, basis, polynomials);
    // Every so many points in the order of a curve through space would be better spread, but a region's
    // vertices are in an order that is almost one.
    std::vector<int> some;
    for (int k = 0; k < first; ++k)
        if (const auto i = static_cast<int>(static_cast<std::int64_t>(k) * m / first); !sum.is_row(i))
            some.push_back(i);
    sum.add(some);
    for (;;) {
        double error = sum.error();
        while (error > tolerance &&
               sum.extend(std::clamp(sum.centre_count() / 8, first_block, largest_block))) {
            error = sum.error();
            progress.tick(std::clamp(std::log(1.0 / error) / std::log(1.0 / tolerance), 0.0, 0.95),
                          "choosing centres");
        }
        RbfFit fit = sum.fit();
        fit.error = error;
        const std::vector<int> more =
            first < m ? missed(sum, fit, points, values, basis, polynomials, tolerance) : std::vector<int>{};
        if (more.empty())
            return fit;
        sum.add(more);
    }
}

} // namespace sinew
