// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/optimization/metric_lbfgs.h"

#include "native/solvers/optimization/kernels.h"
#include "tests/native/dense.h"
#include "tests/native/shapes.h"
#include "tests/native/wide_kernels.h"

#include <cstring>

namespace sinew::test_metric_lbfgs {

/// Any F over dense points, with a dense metric. Its hidden state is the point it saw last.
class DenseProblem : public MetricProblem
{
public:
    explicit DenseProblem(const MatrixX& metric) : metric_(metric) {}

    double evaluate(const Points& x, Points& gradient) final
    {
        ++evaluations;
        state = x;
        return value(x, gradient);
    }
    void precondition(const Points& gradient, Points& z) const final
    {
        z = dense::solution(metric_, gradient);
    }
    void keep_state() final { kept_ = state; }
    void restore_state() final { state = kept_; }

    virtual double value(const Points& x, Points& gradient) const = 0;

    Points state;
    int evaluations = 0;

private:
    Points kept_;
    MatrixX metric_;
};

class Quadratic final : public DenseProblem
{
public:
    Quadratic(const MatrixX& A, const MatrixX& metric) : DenseProblem(metric), A_(A)
    {
        b_ = shapes::Random(4).dense(static_cast<int>(A.rows()), 3);
        least_ = 0.5 * b_.cwiseProduct(minimum()).sum();
    }
    double value(const Points& x, Points& gradient) const override
    {
        gradient = dense::product(A_, x) - b_;
        // 1 at the minimum: stopping rules compare with F itself.
        return 1 + least_ + 0.5 * x.cwiseProduct(gradient - b_).sum();
    }
    Points minimum() const { return dense::solution(A_, b_); }

private:
    MatrixX A_, b_;
    double least_ = 0.0;
};

/// A bowl full of dents; with a metric of `bound` times its true curvature bound.
class Dented final : public DenseProblem
{
public:
    Dented(int n, double bound) : DenseProblem(bound * (1 + depth * rate * rate) * MatrixX::Identity(n, n)) {}
    double value(const Points& x, Points& gradient) const override
    {
        gradient = (x.array() + depth * rate * (rate * x.array() + 1).cos()).matrix();
        return 0.5 * x.squaredNorm() + depth * ((rate * x.array() + 1).sin() + 1).sum();
    }

private:
    static constexpr double depth = 0.6;
    static constexpr double rate = 4.0;
};

Points start(int n) { return 3 * shapes::Random(9).dense(n, 3); }

LbfgsOptions budget(int iterations) { return {.max_iterations = iterations, .tolerance = 0.0}; }

/// F after 0, 1, 2 ... iterations from the same start, each checked against the point returned.
template <class Make>
std::vector<double> energies(Make&& make, int n, int most, int window = 5)
{
    std::vector<double> result;
    for (int k = 0; k <= most; ++k) {
        auto problem = make();
        Points x = start(n), gradient;
        const SolveReport report =
            minimize(problem, x, {.max_iterations = k, .tolerance = 0.0, .window = window});
        EXPECT_LE(report.iterations, k);
        EXPECT_EQ(problem.evaluations, report.iterations + 1) << "each after the first is an iteration";
        EXPECT_EQ(problem.state, x) << "the hidden state belongs to another point";
        EXPECT_EQ(report.energy, problem.value(x, gradient)) << "reported for another point";
        EXPECT_TRUE(result.empty() || report.energy <= result.back()) << "raised by iteration " << k;
        result.push_back(report.energy);
    }
    return result;
}

TEST(MetricLbfgs, finds_the_minimum_of_a_quadratic_at_once_or_under_a_bounding_metric)
{
    const MatrixX A = dense::random_definite(20, 1, 1.0);
    Quadratic known(A, A);
    Points x = start(20);
    minimize(known, x, budget(1));
    EXPECT_LT(shapes::distance(x, known.minimum()), 1e-12); // condition below 1e3
    EXPECT_TRUE(minimize(known, x, budget(20)).converged);
    EXPECT_LT(shapes::distance(x, known.minimum()), 1e-12) << "it stays there";

    int before = 0;
    for (const double tolerance : {1e-2, 1e-8, 0.0}) {
        Quadratic problem(A, A.trace() * MatrixX::Identity(20, 20));
        x = start(20);
        const SolveReport report = minimize(problem, x, {.max_iterations = 500, .tolerance = tolerance});
        EXPECT_TRUE(report.converged);
        EXPECT_GT(report.iterations, before);
        EXPECT_LT(report.residual, std::max(tolerance, 1e-8));
        before = report.iterations;
    }
    // F stops falling when steps are of sqrt(epsilon): half the digits in x.
    EXPECT_LT(shapes::distance(x, known.minimum()), 1e-6);
}

TEST(MetricLbfgs, never_raises_the_function_and_is_faster_than_plain_steps_in_the_same_metric)
{
    const MatrixX A = dense::random_definite(30, 3, 1.0);
    const auto make = [&] { return Quadratic(A, A.trace() * MatrixX::Identity(30, 30)); };
    Points gradient;
    const double least = make().value(make().minimum(), gradient);
    const double plain = energies(make, 30, 30, 0).back(), quick = energies(make, 30, 30).back();
    EXPECT_LT(quick - least, 0.05 * (plain - least)); // 0.02 with exact sums
    for (double bound : {1.0, 0.2, 0.02})             // a metric that is no bound
        energies([&] { return Dented(12, bound); }, 12, 40);
}

TEST(MetricLbfgs, says_when_it_ends_before_a_minimum_and_can_be_cancelled)
{
    Dented problem(12, 5.0);
    Points x = start(12);
    const SolveReport exhausted = minimize(problem, x, budget(3));
    EXPECT_EQ(exhausted.iterations, 3);
    EXPECT_FALSE(exhausted.converged);
    EXPECT_GT(exhausted.residual, 0.0);

    const Points before = x;
    const SolveReport below = minimize(problem, x, {.max_iterations = 10, .tolerance = 0, .floor = 1e9});
    EXPECT_EQ(below.iterations, 0);
    EXPECT_TRUE(below.converged);
    EXPECT_EQ(x, before);

    int ticks = 0;
    const Progress progress([&](double fraction, const char*) {
        EXPECT_GE(fraction, 0.0);
        EXPECT_LT(fraction, 1.0);
        return ++ticks < 4;
    });
    EXPECT_THROW(minimize(problem, x, budget(30), progress), Cancelled);
    EXPECT_EQ(ticks, 4);
}

TEST(MetricLbfgs, a_plain_step_that_lowers_nothing_ends_it)
{
    class Flat final : public DenseProblem
    {
    public:
        Flat() : DenseProblem(MatrixX::Identity(4, 4)) {}
        double value(const Points& x, Points& gradient) const override
        {
            gradient = 1e-9 * x; // which F does not show: it is rounded
            return 1.0;
        }
    } problem;
    Points x = start(4);
    const Points before = x;
    const SolveReport report = minimize(problem, x, budget(20));
    EXPECT_TRUE(report.converged);
    EXPECT_EQ(report.iterations, 1);
    EXPECT_EQ(x, before);
    EXPECT_EQ(problem.state, before);
}

TEST(MetricLbfgs, its_wide_kernels_agree_with_the_plain_ones_to_the_last_bit)
{
    constexpr int pairs = 3;
    for (int count : {1, 4, 15, 16, 100, 1001}) {
        const VectorX x = VectorX::Random(count), g = VectorX::Random(count), old_g = VectorX::Random(count);
        const VectorX z = VectorX::Random(count), old_z = VectorX::Random(count);
        const Eigen::MatrixXf s = Eigen::MatrixXf::Random(count, pairs);
        const Eigen::MatrixXf Ly = Eigen::MatrixXf::Random(count, pairs);
        const float *s_of[pairs], *Ly_of[pairs];
        const double share_s[pairs]{0.3, -0.2, 1.7}, share_Ly[pairs]{-0.9, 0.6, 0.1}, t = 0.7;
        VectorX d = z;
        for (int k = 0; k < pairs; ++k) {
            s_of[k] = s.col(k).data();
            Ly_of[k] = Ly.col(k).data();
            d += share_s[k] * s.col(k).cast<double>() - share_Ly[k] * Ly.col(k).cast<double>();
        }
        VectorX expected;
        for (const LbfgsKernels* kernels : every_kernels<LbfgsKernels>()) {
            VectorX trial(count), products(2 * pairs);
            Eigen::VectorXf step(count), fresh(count);
            kernels->step(x.data(), z.data(), pairs, s_of, Ly_of, share_s, share_Ly, t, count, trial.data(),
                          step.data());
            const PairProducts sums = kernels->pair(old_g.data(), g.data(), old_z.data(), z.data(),
                                                    step.data(), count, fresh.data());
            kernels->products(g.data(), pairs, s_of, Ly_of, count, products.data());
            constexpr int size = sizeof sums / sizeof(double);
            VectorX all(3 * count + 2 * pairs + size), numbers(size);
            std::memcpy(numbers.data(), &sums, sizeof sums);
            all << trial, products, step.cast<double>(), fresh.cast<double>(), numbers;
            if (kernels == &LbfgsKernels::baseline)
                expected = all;
            EXPECT_EQ(all, expected);
            EXPECT_LT((trial - (x - t * d)).cwiseAbs().maxCoeff(), 1e-14); // ten numbers up to 1
            EXPECT_NEAR(products[3], g.dot(Ly.col(1).cast<double>()), 1e-13 * count);
            EXPECT_NEAR(sums.y_Ly, (g - old_g).dot((z - old_z).cast<float>().cast<double>()), 1e-13 * count);
        }
    }
}

TEST(MetricLbfgs, admitted_points_keep_a_constraint_and_reach_the_least_value_on_it)
{
    /// 1 + 1/2 |x - c|^2 on the sphere |x| = 1, least at c / |c|.
    class OnSphere final : public MetricProblem
    {
    public:
        Points c = Points::Zero(4, 3);
        int outside = 0;
        double evaluate(const Points& x, Points& gradient) override
        {
            outside += std::abs(x.norm() - 1) > 1e-12;
            gradient = x - c;
            gradient -= (gradient.cwiseProduct(x).sum()) * x;
            return 1 + 0.5 * (x - c).squaredNorm();
        }
        void precondition(const Points& gradient, Points& z) const override { z = 0.5 * gradient; }
        void keep_state() override {}
        void restore_state() override {}
        bool admit(Points& x) override
        {
            x /= x.norm();
            return true;
        }
    } problem;
    problem.c = shapes::Random(1).dense(4, 3);
    Points x = shapes::Random(2).dense(4, 3);
    problem.admit(x);
    const SolveReport report = minimize(problem, x, {.max_iterations = 60, .tolerance = 1e-15});
    EXPECT_EQ(problem.outside, 0);
    EXPECT_LE(report.iterations, 30);
    EXPECT_LT(shapes::distance(x, Points(problem.c / problem.c.norm())), 1e-6); // the root of the tolerance
}

TEST(MetricLbfgs, shorter_plain_steps_help_where_the_metric_is_too_small)
{
    const MatrixX A = 5 * MatrixX::Identity(6, 6);
    for (const int steps : {1, 4}) {
        Quadratic problem(A, MatrixX::Identity(6, 6)); // x - L^-1 g goes five times too far
        Points x = Points::Zero(6, 3);
        const SolveReport report =
            minimize(problem, x, {.max_iterations = 50, .tolerance = 1e-14, .plain_steps = steps});
        EXPECT_EQ(report.converged, steps == 4);
        if (steps == 1)
            EXPECT_EQ(x, Points::Zero(6, 3)) << "nothing was gained";
        else
            EXPECT_LT(shapes::distance(x, problem.minimum()), 1e-6);
    }
}

/// A quadratic with one soft direction, along the ones, in which a coarse step goes `share` of the way to the
/// minimum.
class Soft final : public DenseProblem
{
public:
    explicit Soft(double share) : DenseProblem(MatrixX::Identity(count, count)), share_(share) {}
    double value(const Points& x, Points& gradient) const override
    {
        const Eigen::RowVector3d mean = x.colwise().mean();
        const Points rest = x.rowwise() - mean;
        gradient = rest.rowwise() + softness * mean;
        return 0.5 * (rest.squaredNorm() + softness * count * mean.squaredNorm());
    }
    bool improve(Points& x, Points& gradient, double& F) override
    {
        if (share_ == 0)
            return false;
        x = x.rowwise() - share_ * x.colwise().mean();
        F = value(x, gradient);
        state = x;
        return true;
    }
    bool go_on(const Points& from, double F_from, double share, Points& x, Points& gradient,
               double& F) override
    {
        went_on = share;
        if (!may_go_on)
            return false;
        x += share * (x - from);
        F = value(x, gradient);
        return F < F_from;
    }

    static constexpr int count = 40;
    bool may_go_on = false;
    double went_on = 0.0;

private:
    static constexpr double softness = 1e-3;
    double share_;
};

TEST(MetricLbfgs, coarse_steps_settle_what_steps_hardly_change)
{
    Soft improved(1.0), alone(0.0);
    Points x = start(Soft::count), y = x, gradient;
    const SolveReport report = minimize(improved, x, budget(2));
    EXPECT_LT(x.norm(), 1e-6); // in single precision, pairs bend the steps by some 1e-7
    EXPECT_EQ(improved.state, x);
    EXPECT_EQ(report.energy, improved.value(x, gradient));
    minimize(alone, y, budget(2));
    EXPECT_GT(y.norm(), 1e-2);
}

TEST(MetricLbfgs, a_size_ends_it_when_no_row_has_more_than_a_share_of_that_left_to_go)
{
    for (const double share : {0.6, 0.2})
        for (const double tolerance : {1e-3, 1e-6}) {
            Soft problem(share);
            Points x = start(Soft::count);
            const SolveReport report = minimize(
                problem, x, {.max_iterations = 100, .tolerance = tolerance, .size = 10.0, .window = 0});
            EXPECT_TRUE(report.converged);
            EXPECT_LT(report.residual, tolerance);
            const double left = x.rowwise().norm().maxCoeff() / 10;
            EXPECT_LT(left, 1.01 * report.residual);
            EXPECT_GT(left, 0.1 * tolerance) << "late";
        }
}

TEST(MetricLbfgs, it_goes_on_at_the_end_by_what_steady_steps_leave)
{
    for (const double share : {0.5, 0.2}) { // from 1 to 1 - share, and to the square of that
        const double last = share * (1 - share), left = (1 - share) * (1 - share);
        const double on = std::min((1 - share) / share, 1.5); // it is bounded
        for (const bool may : {false, true}) {
            Soft problem(share);
            problem.may_go_on = may;
            Points x = Points::Ones(Soft::count, 3), gradient;
            const double estimate = std::max(last, 0.5 * left); // if it goes on
            const SolveReport report = minimize(problem, x,
                                                {.max_iterations = 40,
                                                 .tolerance = 1.05 * std::sqrt(3) * estimate,
                                                 .size = 1.0,
                                                 .window = 0});
            EXPECT_TRUE(report.converged);
            EXPECT_EQ(report.energy, problem.value(x, gradient));
            EXPECT_EQ(report.iterations == 1, may || share == 0.5);
            if (may) {
                EXPECT_NEAR(x.maxCoeff(), left - on * last, 5e-3); // the softness
                EXPECT_NEAR(x.minCoeff(), left - on * last, 5e-3);
            }
        }
    }
}

} // namespace sinew::test_metric_lbfgs
