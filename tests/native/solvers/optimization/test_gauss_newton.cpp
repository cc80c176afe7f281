// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/optimization/gauss_newton.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sinew::test_gauss_newton {

constexpr double infinite = std::numeric_limits<double>::infinity();

VectorX vector(std::initializer_list<double> numbers)
{
    VectorX v(static_cast<Eigen::Index>(numbers.size()));
    std::ranges::copy(numbers, v.data());
    return v;
}

/// H. H. Rosenbrock's valley: r = (10 (y - x^2), 1 - x), with the minimum 0 at (1, 1).
class Valley : public LeastSquares
{
public:
    double radius = infinite; ///< a side: x^2 + y^2 <= radius^2

    void evaluate(const VectorX& x, Values& values) override
    {
        x_ = x;
        values.residuals = vector({10 * (x[1] - x[0] * x[0]), 1 - x[0]});
        values.squares = 0.5 * values.residuals.squaredNorm();
        values.sides.resize(std::isfinite(radius) ? 1 : 0);
        if (values.sides.size() > 0)
            values.sides[0] = x.squaredNorm() - radius * radius;
    }
    void linearize(const VectorX& multipliers, Slopes& slopes) override
    {
        const double first = 10 * (x_[1] - x_[0] * x_[0]);
        slopes.rows.resize(2, 2);
        slopes.rows << -20 * x_[0], 10, -1, 0;
        slopes.diagonal = VectorX::Zero(2);
        slopes.gradient = slopes.rows.transpose() * vector({first, 1 - x_[0]});
        slopes.curvature = MatrixX::Zero(2, 2);
        slopes.curvature(0, 0) = -20 * first;
        slopes.sides.resize(multipliers.size(), 2);
        if (multipliers.size() > 0) {
            slopes.sides.row(0) = 2 * x_.transpose();
            slopes.curvature += 2 * multipliers[0] * MatrixX::Identity(2, 2);
        }
    }

private:
    VectorX x_;
};

/// 1/2 |x - goal|^2.
class Distance : public LeastSquares
{
public:
    explicit Distance(VectorX goal) : goal_(std::move(goal)) {}

    void evaluate(const VectorX& x, Values& values) override
    {
        x_ = x;
        values.residuals = x - goal_;
        values.squares = 0.5 * values.residuals.squaredNorm();
        values.sides.resize(0);
    }
    void linearize(const VectorX& /*multipliers*/, Slopes& slopes) override
    {
        const auto n = goal_.size();
        slopes.rows = MatrixX::Identity(n, n);
        slopes.diagonal = VectorX::Zero(n);
        slopes.gradient = x_ - goal_;
        slopes.curvature = MatrixX::Zero(n, n);
        slopes.sides.resize(0, n);
    }

private:
    VectorX goal_, x_;
};

VariableLimits unlimited(Eigen::Index n)
{
    return {VectorX::Constant(n, -infinite), VectorX::Constant(n, infinite), {}};
}

TEST(GaussNewton, FollowsANarrowValleyAndStopsAtABound)
{
    for (const double most : {infinite, 0.5}) {
        Valley valley;
        VariableLimits limits = unlimited(2);
        limits.upper[0] = most; // the valley's lowest point there is y = x^2
        VectorX x = vector({-1.2, 1});
        const GaussNewtonReport report = minimize(valley, limits, x);
        EXPECT_TRUE(report.converged);
        EXPECT_LT(report.iterations + report.rejected, 30);
        const double end = std::min(most, 1.0);
        EXPECT_LT((x - vector({end, end * end})).norm(), 1e-9);
        EXPECT_LE(x[0], most);
    }
}

TEST(GaussNewton, StopsAtASide)
{
    Valley valley;
    valley.radius = 1;
    VectorX x = vector({-0.5, 0.2});
    const GaussNewtonReport report = minimize(valley, unlimited(2), x);
    EXPECT_TRUE(report.converged);
    EXPECT_LE(report.violation, 1e-9);
    EXPECT_NEAR(x.norm(), 1.0, 1e-9);
    // Known from a fine search along the circle.
    std::pair<double, double> best{infinite, 0.0};
    for (double a = 0; a < 1.57; a += 1e-5)
        best = std::min(best, {50 * std::pow(std::sin(a) - std::pow(std::cos(a), 2), 2) +
                                   0.5 * std::pow(1 - std::cos(a), 2),
                               a});
    EXPECT_NEAR(std::atan2(x[1], x[0]), best.second, 2e-5);
}

TEST(GaussNewton, SlidesAlongABall)
{
    Distance nothing{VectorX()};
    VectorX none;
    EXPECT_EQ(minimize(nothing, unlimited(0), none).iterations, 0);
    Distance distance(vector({3, 0, 4, 7}));
    VariableLimits limits = unlimited(4);
    limits.balls.push_back({0, 2.0});
    for (const VectorX& start : {vector({0, 0, 0, 0}), vector({0, 2, 0, 0}), vector({-9, 1, 2, 3})}) {
        VectorX x = start;
        const GaussNewtonReport report = minimize(distance, limits, x);
        EXPECT_TRUE(report.converged);
        EXPECT_LE(x.head<3>().norm(), 2.0); // never beyond
        EXPECT_LT((x - vector({1.2, 0, 1.6, 7})).norm(), 1e-6);
    }
}

} // namespace sinew::test_gauss_newton
