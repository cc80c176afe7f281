// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/points/rbf/incremental.h"

#include "native/core/dense.h"
#include "native/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

namespace sinew {

namespace {

/// So many points are fitted at first.
constexpr int first_points = 8000;
/// So many of those that are missed join them at once.
constexpr int most_missed = 4000;
/// Centres that are added at first; later half as many as there are.
constexpr int first_block = 32;
/// Nearest earlier centres that the preconditioner knows of each: with 30, half as many iterations again.
constexpr int near_count = 60;
/// A centre whose function is, up to this share, a sum of others is softened so far in the preconditioner.
constexpr double least_pivot = 1e-13;
/// What the centres may miss, as a share of the tolerance.
constexpr double missed_share = 0.3;
/// The same tolerance as a share of the error before, while that is large.
constexpr double loose_share = 0.02;
/// If fewer of the rows are missed, as a share of the centres, they are the last ones, with those that
/// nearly are.
constexpr double last_share = 0.125, nearly_missed = 0.7;
/// Mostly 5 to 20 are enough; centres that nearly coincide take more, up to what rounding leaves.
constexpr int most_iterations = 100;

/// The function as a sum over centres, which gains centres in blocks.
class Sum
{
public:
    Sum(const Points& points, const RowMatrix& values, const RbfBasis& basis, const Polynomials& polynomials)
        : points_(points), basis_(basis), base_(polynomials.evaluate(points)),
          columns_(static_cast<int>(values.cols())), weights_(0, columns_)
    {
        places_ = points(base_.points, Eigen::all);
        of_base_ = values(base_.points, Eigen::all);
        const RowMatrix at_base = rbf_values(basis, points, places_), lagrange = base_.lagrange,
                        half = at_base - product(0.5 * lagrange, at_base(base_.points, Eigen::all));
        left_.resize(points.rows(), 2 * lagrange.cols());
        left_ << -lagrange, -half;
        right_.resize(points.rows(), left_.cols());
        right_ << half, lagrange;
        wanted_ = values - product(lagrange, of_base_);
        residuals_ = wanted_;
        is_row_.assign(static_cast<std::size_t>(points.rows()), 0);
        for (const int point : base_.points)
            is_row_[static_cast<std::size_t>(point)] = 1; // they are met by the polynomials
    }

    bool is_row(int point) const { return is_row_[static_cast<std::size_t>(point)] != 0; }

    /// Takes more points into the fit, whose residuals are known.
    void add(const std::vector<int>& points)
    {
        const int old = row_count();
        for (const int point : points) {
            is_row_[static_cast<std::size_t>(point)] = 1;
            rows_.push_back(point);
            distances_.push_back(1.0);
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
    }

    /// The largest residual of a row.
    double error() const
    {
        double most = 0.0;
        for (const int row : rows_)
            most = std::max(most, residual(row));
        return most;
    }

    /// Makes rows that are missed centres. \return whether there are any.
    bool extend(double tolerance, const Progress& progress)
    {
        const double before = error();
        const int count = before <= tolerance ? 0 : choose(std::max(first_block, done_ / 2), tolerance);
        const double goal =
            missed_share * (count > 0 ? std::max(tolerance, loose_share * before) : tolerance);
        if (count == 0 && (before <= tolerance || goal_ <= goal))
            return false;
        goal_ = goal;
        near_.resize(static_cast<std::size_t>(done_ + count));
        weights_.conservativeResize(done_ + count, Eigen::NoChange);
        weights_.bottomRows(count).setZero();
        done_ += count;
        const Points places = points_(chosen(), Eigen::all);
        parallel_for(count, [&](int i) { near_[done_ - count + i] = near(done_ - count + i, places); }, 4);
        solve(goal, progress, std::clamp(std::log(1.0 / before) / std::log(1.0 / tolerance), 0.0, 0.95));
        find_residuals(rows_);
        return true;
    }

    /// The points without a row that are missed, the worst ones first.
    std::vector<int> missed(double tolerance)
    {
        std::vector<int> all;
        for (int i = 0; i < points_.rows(); ++i)
            if (!is_row(i))
                all.push_back(i);
        find_residuals(all);
        std::erase_if(all, [&](int i) { return !(residual(i) > tolerance); });
        std::ranges::stable_sort(all, std::greater<>(), [&](int i) { return residual(i); });
        all.resize(std::min<std::size_t>(all.size(), most_missed));
        return all;
    }

    RbfFit fit() const
    {
        RbfFit fit{centres(), {with_base(weights_), {}}, error()};
        fit.coefficients.polynomial = product(
            base_.inverse, of_base_ - rbf_sums(basis_, places_, fit.centres, fit.coefficients.weights));
        return fit;
    }

private:
    /// A column of the preconditioner.
    struct Near
    {
        std::vector<int> centres; ///< the nearest of those before, and itself as the last one
        VectorX factors;
    };

    int row_count() const { return static_cast<int>(rows_.size()); }
    double distance(int a, int b) const { return (points_.row(a) - points_.row(b)).norm(); }
    double residual(int point) const { return residuals_.row(point).cwiseAbs().sum(); }
    std::vector<int> chosen() const { return {rows_.begin(), rows_.begin() + done_}; }

    /// The centres, and then the base points.
    Points centres() const
    {
        Points all(done_ + places_.rows(), 3);
        all << points_(chosen(), Eigen::all), places_;
        return all;
    }

    /// The weights of centres() from those of the centres alone.
    RowMatrix with_base(const RowMatrix& weights) const
    {
        RowMatrix all(done_ + places_.rows(), columns_);
        all << weights, -transposed_product(base_.lagrange(chosen(), Eigen::all), weights);
        return all;
    }

    /// psi of weights of the centres, at some points.
    RowMatrix psi_sums(const std::vector<int>& points, const RowMatrix& weights) const
    {
        const Points from = centres();
        const RowMatrix all = with_base(weights);
        return rbf_sums(basis_, points_(points, Eigen::all), from, all) -
               product(base_.lagrange(points, Eigen::all), rbf_sums(basis_, places_, from, all));
    }

    void find_residuals(const std::vector<int>& points)
    {
        if (done_ > 0 && !points.empty())
            residuals_(points, Eigen::all) = wanted_(points, Eigen::all) - psi_sums(points, weights_);
    }

    /// Moves rows of the largest residual times distance from the centres so far behind these. Residuals are
    /// known before the first of them only: near it they are taken to fall by the fourth power of the
    /// distance.
    int choose(int count, double tolerance)
    {
        std::vector<double> sizes(rows_.size()), before = distances_;
        for (int i = done_; i < row_count(); ++i)
            sizes[i] = residual(rows_[i]);
        const auto missed = std::ranges::count_if(sizes, [&](double size) { return size > tolerance; });
        const bool is_last = static_cast<double>(missed) < last_share * done_;
        const double least = is_last ? nearly_missed * tolerance : tolerance;
        int found = 0;
        for (int last = -1; found < count; ++found) {
            int best = -1;
            double most = 0.0;
            for (int i = done_ + found; i < row_count(); ++i) {
                if (last >= 0)
                    distances_[i] = std::min(distances_[i], distance(rows_[i], last));
                const double nearer = is_last ? 1.0 : distances_[i] / before[i], square = nearer * nearer,
                             left = sizes[i] * square * square;
                if (const double score = left * distances_[i]; left > least && score > most) {
                    most = score;
                    best = i;
                }
            }
            if (best < 0)
                break;
            last = rows_[best];
            for (auto* list : {&distances_, &sizes, &before})
                std::swap((*list)[best], (*list)[done_ + found]);
            std::swap(rows_[best], rows_[done_ + found]);
        }
        if (found > 0) // the last one counts from the next block on
            for (int i = done_ + found; i < row_count(); ++i)
                distances_[i] = std::min(distances_[i], distance(rows_[i], rows_[done_ + found - 1]));
        return found;
    }

    /// The column of a centre: the last one of the inverse of the Cholesky factor of psi at those near it.
    Near near(int centre, const Points& places) const
    {
        const int count = std::min(centre, near_count);
        const VectorX distances =
            (places.topRows(centre).rowwise() - places.row(centre)).rowwise().squaredNorm();
        Near near;
        if (count > 0) {
            VectorX sorted = distances;
            std::nth_element(sorted.begin(), sorted.begin() + count - 1, sorted.end());
            for (int c = 0; c < centre && std::ssize(near.centres) < count; ++c)
                if (distances[c] <= sorted[count - 1])
                    near.centres.push_back(c);
        }
        near.centres.push_back(centre);
        std::vector<int> points;
        for (const int c : near.centres)
            points.push_back(rows_[c]);
        const Points own = places(near.centres, Eigen::all);
        // Its Cholesky factor, in place, and then the last row of the inverse.
        RowMatrix L = rbf_values(basis_, own, own) +
                      product(left_(points, Eigen::all), right_(points, Eigen::all).transpose());
        for (Eigen::Index i = 0; i <= count; ++i) {
            const double least =
                least_pivot * left_.row(points[i]).cwiseProduct(right_.row(points[i])).cwiseAbs().sum();
            for (Eigen::Index k = 0; k <= i; ++k) {
                const double rest = L(i, k) - L.row(i).head(k).dot(L.row(k).head(k));
                L(i, k) = k < i ? rest / L(k, k) : std::sqrt(std::max(rest, least));
            }
        }
        near.factors = VectorX::Unit(count + 1, count);
        L.triangularView<Eigen::Lower>().transpose().solveInPlace(near.factors);
        return near;
    }

    /// U U^T r, where the columns of U are those of `near_`.
    RowMatrix precondition(const RowMatrix& r) const
    {
        RowMatrix sums = RowMatrix::Zero(r.rows(), r.cols());
        for (const Near& near : near_) {
            Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(r.cols());
            for (std::size_t k = 0; k < near.centres.size(); ++k)
                sum += near.factors[static_cast<Eigen::Index>(k)] * r.row(near.centres[k]);
            for (std::size_t k = 0; k < near.centres.size(); ++k)
                sums.row(near.centres[k]) += near.factors[static_cast<Eigen::Index>(k)] * sum;
        }
        return sums;
    }

    /// Conjugate gradients, until no centre misses more than that. All columns take the same steps, so that
    /// their sum remains the polynomial that it is: all handles together move space by one affine map.
    void solve(double goal, const Progress& progress, double done)
    {
        const std::vector<int> own = chosen();
        RowMatrix r = residuals_(own, Eigen::all), p = RowMatrix::Zero(done_, columns_);
        double former = 1.0;
        for (int k = 0; k < most_iterations && r.cwiseAbs().rowwise().sum().maxCoeff() > goal; ++k) {
            progress.tick(done, "choosing centres");
            const RowMatrix z = precondition(r);
            const double size = r.cwiseProduct(z).sum();
            p = z + size / former * p;
            const RowMatrix change = psi_sums(own, p);
            const double curvature = p.cwiseProduct(change).sum();
            if (!(curvature > 0.0)) // up to rounding
                break;
            weights_ += size / curvature * p;
            r -= size / curvature * change;
            former = size;
        }
    }

    const Points& points_;
    RbfBasis basis_;
    LagrangeBase base_;
    Points places_;     ///< of the base points
    RowMatrix of_base_; ///< the values there
    RowMatrix left_, right_; ///< psi = phi + left right^T
    RowMatrix wanted_; ///< (m, columns) the values less those of the polynomials that meet the base points
    RowMatrix residuals_; ///< (m, columns)
    int columns_, done_ = 0; ///< rows that are centres: the first ones
    std::vector<int> rows_; ///< the points of the fit
    std::vector<double> distances_; ///< of the rows from the nearest centre
    std::vector<char> is_row_;
    double goal_ = std::numeric_limits<double>::infinity(); ///< what the centres may miss
    std::vector<Near> near_; ///< of each centre
    RowMatrix weights_; ///< (centres, columns)
};

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
    while (!some.empty()) {
        sum.add(some);
        while (sum.extend(tolerance, progress)) {
        }
        some = sum.missed(tolerance);
    }
    return sum.fit();
}

} // namespace sinew
