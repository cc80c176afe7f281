// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/points/rbf/incremental.h"

#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/solvers/dense/tall_products.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <vector>

namespace sinew {

namespace {

constexpr int first_block =
    32;  ///< centres that are added at first; later more, in proportion to those so far
constexpr int largest_block = 128;
constexpr int grain = 2048; ///< rows of a product that one thread takes at once
constexpr double dependent = 1e-11; ///< a column of this share of its length is a sum of those before it
constexpr double least_pivot = 1e-12; ///< and one of this pivot is a sum of others of its block

/// Some columns of A = Q R, with orthonormal Q.
struct Block
{
    std::vector<int> chosen;
    MatrixX Q, R;
};

/// A factor of A^T A instead of reflections, since products are fast; a second one makes Q orthogonal to
/// rounding. It leaves out columns that are sums of others.
/// \param lengths  what the columns are compared with.
Block orthogonal(const MatrixX& A, const Eigen::RowVectorXd& lengths)
{
    Block block;
    std::vector<int> left;
    MatrixX scaled = A;
    const Eigen::RowVectorXd own = A.colwise().norm();
    for (int k = 0; k < A.cols(); ++k)
        if (own[k] > dependent * lengths[k]) {
            scaled.col(k) /= own[k];
            left.push_back(k);
        }
    MatrixX G = transposed_product(scaled, A.cols(), scaled);
    MatrixX rows = MatrixX::Zero(A.cols(), A.cols()); // of R, with the columns of A
    while (!left.empty()) {
        const auto best = std::ranges::max_element(left, {}, [&](int k) { return G(k, k); });
        const int k = *best;
        if (!(G(k, k) > least_pivot))
            break;
        left.erase(best);
        const double pivot = std::sqrt(G(k, k));
        const auto row = static_cast<Eigen::Index>(block.chosen.size());
        rows(row, k) = pivot;
        for (const int j : left)
            rows(row, j) = G(k, j) / pivot;
        for (const int i : left)
            for (const int j : left)
                G(i, j) -= rows(row, i) * rows(row, j);
        block.chosen.push_back(k);
    }
    const auto count = static_cast<Eigen::Index>(block.chosen.size());
    block.Q.resize(A.rows(), count);
    block.R.resize(count, count);
    for (Eigen::Index k = 0; k < count; ++k) {
        block.Q.col(k) = scaled.col(block.chosen[static_cast<std::size_t>(k)]);
        block.R.col(k) = rows.col(block.chosen[static_cast<std::size_t>(k)]).head(count);
    }
    const auto divide = [&](const MatrixX& R) {
        parallel_chunks(static_cast<int>(A.rows()), grain, [&](int begin, int end) {
            MatrixX some = block.Q.middleRows(begin, end - begin);
            R.triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(some);
            block.Q.middleRows(begin, end - begin) = some;
        });
    };
    divide(block.R);
    const MatrixX again = transposed_product(block.Q, count, block.Q).llt().matrixU();
    divide(again);
    block.R = again * block.R;
    for (Eigen::Index k = 0; k < count; ++k)
        block.R.col(k) *= own[block.chosen[static_cast<std::size_t>(k)]];
    return block;
}

Points rows_of(const Points& points, const std::vector<int>& rows)
{
    Points some(static_cast<Eigen::Index>(rows.size()), 3);
    for (std::size_t k = 0; k < rows.size(); ++k)
        some.row(static_cast<Eigen::Index>(k)) = points.row(rows[k]);
    return some;
}

/// Chooses the next centres: those of the largest residual times distance from the centres so far.
class Chooser
{
public:
    explicit Chooser(const Points& points)
        : points_(points), distances_(VectorX::Constant(points.rows(), 1.0)),
          taken_(static_cast<std::size_t>(points.rows()), 0)
    {
    }
    void take(int point)
    {
        taken_[static_cast<std::size_t>(point)] = 1;
        const Eigen::RowVector3d at = points_.row(point);
        parallel_for(static_cast<int>(points_.rows()),
                     [&](int i) { distances_[i] = std::min(distances_[i], (points_.row(i) - at).norm()); });
    }
    std::vector<int> choose(const VectorX& residuals, int count)
    {
        std::vector<int> chosen;
        while (static_cast<int>(chosen.size()) < count) {
            int best = -1;
            double most = 0.0;
            for (int i = 0; i < points_.rows(); ++i)
                if (const double score = residuals[i] * distances_[i];
                    !taken_[static_cast<std::size_t>(i)] && score > most) {
                    most = score;
                    best = i;
                }
            if (best < 0)
                break;
            take(best);
            chosen.push_back(best);
        }
        return chosen;
    }

private:
    const Points& points_;
    VectorX distances_;
    std::vector<char> taken_;
};

} // namespace

RbfFit fit_incrementally(const Points& points, const RowMatrix& values, const RbfBasis& basis,
                         const Polynomials& polynomials, double tolerance, int most, const Progress& progress)
{
    const int m = static_cast<int>(points.rows()), q = polynomials.count();
    most = std::min(most, m - q);
    const MatrixX P = polynomials.evaluate(points);
    const LagrangeBase base(P);
    const Points base_points = rows_of(points, base.points);
    const RowMatrix at_base = rbf_values(basis, points, base_points);
    Chooser chooser(points);
    for (const int point : base.points)
        chooser.take(point);

    // P = Q R to begin with; then Q, R and Q^T F grow, and F - Q Q^T F stays.
    int columns = q;
    MatrixX Q(m, std::min(most + q, 256)), R = MatrixX::Zero(Q.cols(), Q.cols()), F = values;
    MatrixX right = MatrixX::Zero(Q.cols(), F.cols());
    if (q > 0) {
        const Eigen::HouseholderQR<MatrixX> qr(P);
        Q.leftCols(q) = qr.householderQ() * MatrixX::Identity(m, q);
        R.topLeftCorner(q, q) = qr.matrixQR().topRows(q).triangularView<Eigen::Upper>();
        right.topRows(q) = transposed_product(Q, q, F);
        subtract_product(Q, q, right.topRows(q), F);
    }
    std::vector<int> centres;
    RbfFit fit;
    for (;;) {
        const VectorX residuals = F.cwiseAbs().rowwise().sum();
        fit.error = m > 0 ? residuals.maxCoeff() : 0.0;
        const int room = most - static_cast<int>(centres.size());
        if (!(fit.error > tolerance) || room <= 0)
            break;
        progress.tick(std::min(0.95, std::log(1.0 / std::min(1.0, fit.error)) / std::log(1.0 / tolerance)),
                      "choosing centres");
        const int block =
            std::min({room, largest_block, std::max(first_block, static_cast<int>(centres.size()) / 4)});
        const std::vector<int> next = chooser.choose(residuals, block);
        if (next.empty())
            break;
        MatrixX A = rbf_values(basis, points, rows_of(points, next));
        if (q > 0) {
            MatrixX lagrange(q, A.cols());
            for (Eigen::Index k = 0; k < A.cols(); ++k)
                lagrange.col(k) = base.lagrange.row(next[static_cast<std::size_t>(k)]).transpose();
            A.noalias() -= at_base * lagrange;
        }
        const Eigen::RowVectorXd lengths = A.colwise().norm();
        MatrixX upper = transposed_product(Q, columns, A);
        subtract_product(Q, columns, upper, A);
        const MatrixX again = transposed_product(Q, columns, A);
        subtract_product(Q, columns, again, A);
        upper += again;
        const Block own = orthogonal(A, lengths);
        const auto added = static_cast<int>(own.chosen.size());
        if (added == 0)
            break;
        if (columns + added > Q.cols()) {
            const Eigen::Index size = std::min<Eigen::Index>(most + q, 2 * Q.cols());
            require_memory(8 * size * m, "the fit of radial basis functions");
            Q.conservativeResize(Eigen::NoChange, size);
            const Eigen::Index old = R.rows();
            R.conservativeResize(size, size);
            R.rightCols(size - old).setZero();
            R.bottomRows(size - old).setZero();
            right.conservativeResize(size, Eigen::NoChange);
        }
        Q.middleCols(columns, added) = own.Q;
        for (int k = 0; k < added; ++k) {
            R.block(0, columns + k, columns, 1) = upper.col(own.chosen[k]);
            centres.push_back(next[static_cast<std::size_t>(own.chosen[k])]);
        }
        R.block(columns, columns, added, added) = own.R;
        right.middleRows(columns, added) = transposed_product(own.Q, added, F);
        subtract_product(own.Q, added, right.middleRows(columns, added), F);
        columns += added;
    }
    MatrixX x = right.topRows(columns);
    R.topLeftCorner(columns, columns).triangularView<Eigen::Upper>().solveInPlace(x);
    fit.coefficients.polynomial = x.topRows(q);
    const auto n = static_cast<Eigen::Index>(centres.size());
    fit.coefficients.weights.resize(n + q, x.cols());
    fit.coefficients.weights.topRows(n) = x.bottomRows(n);
    MatrixX at_base_weights = MatrixX::Zero(q, x.cols());
    for (Eigen::Index k = 0; k < n && q > 0; ++k)
        at_base_weights -= base.lagrange.row(centres[static_cast<std::size_t>(k)]).transpose() * x.row(q + k);
    fit.coefficients.weights.bottomRows(q) = at_base_weights;
    centres.insert(centres.end(), base.points.begin(), base.points.end());
    fit.centres = rows_of(points, centres);
    return fit;
}

} // namespace sinew
