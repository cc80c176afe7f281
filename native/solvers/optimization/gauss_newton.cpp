// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/optimization/gauss_newton.h"

#include "native/core/dense.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {

namespace {

constexpr double at_border = 1e-9; ///< as a share of the radius of a ball
constexpr double least_damping = 1e-12, most_damping = 1e9;
constexpr double most_price = 1e9; ///< of a violated side, in the merit
constexpr double feasible = 1e-12; ///< a side above this is violated

/// The quadratic model of a problem at x, and its minimiser under the limits.
class Model
{
public:
    Model(const LeastSquares::Values& values, const LeastSquares::Slopes& slopes,
          const VariableLimits& limits, const VectorX& x, const VectorX& multipliers);

    /// \param[in,out] damping  is added to the diagonal. It is raised until the matrix with the curvature is
    ///   positive definite.
    /// \param without_curvature  instead of that, the curvature is left out where the matrix is not.
    void solve(double& damping, bool without_curvature);
    bool is_without_curvature() const { return without_curvature_; }

    /// Solves again, with the factor of the last solve(), for what r and c really are after its step.
    /// \return the whole step.
    VectorX bent_step(const LeastSquares::Values& there, double damping);

    const VectorX& step() const { return d_; }
    const VectorX& multipliers() const { return multipliers_; } ///< of the sides
    /// By how much the model says that the step lowers F.
    double predicted() const { return -(slopes_.gradient.dot(d_) + 0.5 * d_.dot(times(undamped_, d_))); }

private:
    bool factorize(double damping);
    void solve_equalities(double& damping, bool without_curvature);
    VectorX free_part(const VectorX& gradient, const VectorX& sides, double damping);
    bool violate_bounds();
    bool change_sides();
    bool change_borders();

    const LeastSquares::Values& values_;
    const LeastSquares::Slopes& slopes_;
    const VariableLimits& limits_;
    const VectorX& x_;
    MatrixX normal_; ///< J^T J with the diagonal
    MatrixX undamped_; ///< the matrix of the step
    bool without_curvature_ = false;
    std::vector<int> free_;
    std::vector<char> fixed_; ///< (n) whether each unknown is at its bound, and stays
    std::vector<char> active_, dropped_; ///< (sides)
    /// A ball that the step may not leave: the step goes `room` along `out` there.
    struct Border
    {
        std::size_t ball;
        Vector3 out;
        double room;
        double force; ///< with which it holds the step back
    };
    std::vector<Border> borders_;
    std::vector<char> first_fixed_, first_active_; ///< as each solve() begins
    std::vector<Border> first_borders_;
    std::vector<char> left_; ///< (balls) whether each border would hold the step back from going inward
    CholeskyFactor factor_;
    MatrixX rows_; ///< of the equalities, for the free unknowns
    MatrixX answers_; ///< of the factor to these rows
    std::vector<Eigen::Index> equal_; ///< the sides that are equalities: the first of the rows
    LeastNorm schur_;
    VectorX d_, multipliers_;
};

Model::Model(const LeastSquares::Values& values, const LeastSquares::Slopes& slopes,
             const VariableLimits& limits, const VectorX& x, const VectorX& multipliers)
    : values_(values), slopes_(slopes), limits_(limits), x_(x),
      normal_(transposed_product(slopes.rows, slopes.rows)), fixed_(x.size(), 0),
      active_(values.sides.size(), 0), dropped_(values.sides.size(), 0),
      multipliers_(VectorX::Zero(values.sides.size()))
{
    VectorX pull = slopes.gradient; // what pushes x out, with the sides' own forces
    if (multipliers.size() > 0)
        pull += transposed_times(slopes.sides, multipliers);
    normal_.diagonal() += slopes.diagonal;
    undamped_ = normal_ + slopes.curvature;
    for (std::size_t k = 0; k < limits.balls.size(); ++k) {
        const VariableLimits::Ball& ball = limits.balls[k];
        const auto turn = x.segment<3>(ball.first);
        const double length = turn.norm();
        if (length < ball.radius * (1 - at_border) || length == 0)
            continue;
        const Vector3 out = turn / length;
        const double force = -pull.segment<3>(ball.first).dot(out);
        if (force <= 0)
            continue;
        borders_.push_back({k, out, ball.radius - length, force});
        // The border curves inward: moving along it costs what the force outward does not get.
        undamped_.block<3, 3>(ball.first, ball.first) +=
            force / length * (Matrix3::Identity() - out * out.transpose());
    }
    for (Eigen::Index i = 0; i < x.size(); ++i)
        fixed_[i] = (x[i] <= limits.lower[i] && pull[i] >= 0) || (x[i] >= limits.upper[i] && pull[i] <= 0);
    for (Eigen::Index k = 0; k < values.sides.size(); ++k)
        active_[k] = values.sides[k] > feasible || multipliers[k] > 0;
    first_fixed_ = fixed_;
    first_active_ = active_;
    first_borders_ = borders_;
}

bool Model::factorize(double damping)
{
    MatrixX reduced = undamped_(free_, free_);
    reduced.diagonal().array() += damping;
    return factor_.factorize(reduced);
}

/// The step whose entries at `fixed_` unknowns are given.
void Model::solve_equalities(double& damping, bool without_curvature)
{
    free_.clear();
    for (Eigen::Index i = 0; i < x_.size(); ++i)
        if (!fixed_[i]) {
            free_.push_back(static_cast<int>(i));
            d_[i] = 0.0;
        } else {
            d_[i] = std::clamp(x_[i] + d_[i], limits_.lower[i], limits_.upper[i]) - x_[i];
        }
    multipliers_.setZero();
    if (free_.empty())
        return;
    while (!factorize(damping) && damping < most_damping)
        if (without_curvature && !without_curvature_) {
            undamped_ = normal_;
            without_curvature_ = true;
        } else {
            damping = std::max(3 * damping, 1e-9);
        }
    equal_.clear();
    for (Eigen::Index k = 0; k < values_.sides.size(); ++k)
        if (active_[k])
            equal_.push_back(k);
    const auto sides = static_cast<Eigen::Index>(equal_.size());
    rows_.setZero(sides + static_cast<Eigen::Index>(borders_.size()),
                  static_cast<Eigen::Index>(free_.size()));
    for (Eigen::Index k = 0; k < sides; ++k)
        rows_.row(k) = slopes_.sides.row(equal_[k])(free_);
    for (std::size_t k = 0; k < borders_.size(); ++k) {
        const auto first =
            std::ranges::lower_bound(free_, limits_.balls[borders_[k].ball].first); // never fixed
        rows_.block<1, 3>(sides + static_cast<Eigen::Index>(k), first - free_.begin()) =
            borders_[k].out.transpose();
    }
    if (rows_.rows() > 0) {
        answers_ = factor_.solve(MatrixX(rows_.transpose()));
        // Rows that depend on each other, or on fixed unknowns alone, count once.
        schur_.factorize(product(rows_, answers_), 1e-12);
    }
    const VectorX part = free_part(slopes_.gradient, values_.sides, damping);
    for (std::size_t k = 0; k < free_.size(); ++k)
        d_[free_[k]] = part[static_cast<Eigen::Index>(k)];
}

/// The free entries of the step for a gradient and for values of the sides, beside the fixed ones in d_.
VectorX Model::free_part(const VectorX& gradient, const VectorX& sides, double damping)
{
    VectorX fixed = d_;
    for (int i : free_)
        fixed[i] = 0.0;
    VectorX part = -factor_.solve(VectorX((gradient + times(undamped_, fixed))(free_)));
    if (rows_.rows() == 0)
        return part;
    const double shorter = 1.0 / (1.0 + damping); // much damping makes that part of a step shorter, too
    VectorX goal = VectorX::Zero(rows_.rows());
    for (std::size_t k = 0; k < equal_.size(); ++k)
        goal[static_cast<Eigen::Index>(k)] =
            -shorter * sides[equal_[k]] - slopes_.sides.row(equal_[k]).dot(fixed);
    const auto sides_count = static_cast<Eigen::Index>(equal_.size());
    for (std::size_t k = 0; k < borders_.size(); ++k)
        goal[sides_count + static_cast<Eigen::Index>(k)] = borders_[k].room;
    const VectorX forces = schur_.solve(times(rows_, part) - goal);
    for (std::size_t k = 0; k < equal_.size(); ++k)
        multipliers_[equal_[k]] = forces[static_cast<Eigen::Index>(k)];
    for (std::size_t k = 0; k < borders_.size(); ++k)
        borders_[k].force = forces[sides_count + static_cast<Eigen::Index>(k)];
    return part - times(answers_, forces);
}

VectorX Model::bent_step(const LeastSquares::Values& there, double damping)
{
    if (free_.empty())
        return d_;
    const VectorX bent = there.residuals - values_.residuals - times(slopes_.rows, d_);
    VectorX sides = there.sides, whole = d_;
    if (sides.size() > 0)
        sides -= times(slopes_.sides, d_);
    const VectorX kept = multipliers_;
    const VectorX part = free_part(slopes_.gradient + transposed_times(slopes_.rows, bent), sides, damping);
    multipliers_ = kept;
    for (std::size_t k = 0; k < free_.size(); ++k)
        whole[free_[k]] = part[static_cast<Eigen::Index>(k)];
    return whole;
}

/// Fixes the unknowns that the step takes beyond their bounds.
bool Model::violate_bounds()
{
    bool any = false;
    for (int i : free_) {
        const double there = x_[i] + d_[i];
        if (there < limits_.lower[i] || there > limits_.upper[i]) {
            fixed_[i] = 1;
            any = true;
        }
    }
    return any;
}

/// Takes in sides that the step violates, and leaves out those that would hold it back.
bool Model::change_sides()
{
    bool any = false;
    for (Eigen::Index k = 0; k < values_.sides.size(); ++k) {
        const bool violated = values_.sides[k] + slopes_.sides.row(k).dot(d_) > feasible;
        if (active_[k] && multipliers_[k] < 0) {
            active_[k] = 0;
            dropped_[k] = 1;
            any = true;
        } else if (!active_[k] && violated && !dropped_[k]) {
            active_[k] = 1;
            any = true;
        }
    }
    return any;
}

/// The same for balls.
bool Model::change_borders()
{
    const std::size_t before = borders_.size();
    std::erase_if(borders_, [&](const Border& border) {
        if (border.force < 0)
            left_[border.ball] = 1;
        return border.force < 0;
    });
    bool any = borders_.size() < before;
    for (std::size_t k = 0; k < limits_.balls.size(); ++k) {
        const VariableLimits::Ball& ball = limits_.balls[k];
        const auto here = x_.segment<3>(ball.first);
        const Vector3 there = here + d_.segment<3>(ball.first);
        if (there.norm() <= ball.radius || left_[k] ||
            std::ranges::any_of(borders_, [&](const Border& border) { return border.ball == k; }))
            continue;
        const Vector3 out = there.normalized();
        borders_.push_back({k, out, ball.radius - out.dot(here), 0.0});
        any = true;
    }
    return any;
}

void Model::solve(double& damping, bool without_curvature)
{
    d_ = VectorX::Zero(x_.size());
    fixed_ = first_fixed_;
    active_ = first_active_;
    borders_ = first_borders_;
    std::ranges::fill(dropped_, 0);
    left_.assign(limits_.balls.size(), 0);
    const Eigen::Index most =
        x_.size() + 2 * (values_.sides.size() + static_cast<Eigen::Index>(left_.size()));
    for (Eigen::Index k = 0; k <= most; ++k) {
        solve_equalities(damping, without_curvature);
        const bool bounds = violate_bounds(), balls = change_borders();
        if (!bounds && !balls && !change_sides())
            break;
    }
    for (int i : free_)
        d_[i] = std::clamp(x_[i] + d_[i], limits_.lower[i], limits_.upper[i]) - x_[i];
}

/// Shortest steps until no side is violated, if the limits allow that.
void move_inside(LeastSquares& problem, const VariableLimits& limits, VectorX& x,
                 LeastSquares::Values& values, LeastSquares::Slopes& slopes)
{
    const VectorX none = VectorX::Zero(values.sides.size());
    for (int k = 0; k < 10 && values.sides.maxCoeff() > feasible; ++k) {
        problem.evaluate(x, values);
        problem.linearize(none, slopes);
        MatrixX rows = slopes.sides;
        VectorX goal = values.sides;
        for (Eigen::Index side = 0; side < goal.size(); ++side)
            if (goal[side] <= 0) {
                rows.row(side).setZero();
                goal[side] = 0.0;
            }
        for (Eigen::Index i = 0; i < x.size();
             ++i) // the sum of the violated sides pushes each unknown one way
            if (const double push = rows.col(i).sum();
                (push > 0 && x[i] <= limits.lower[i]) || (push < 0 && x[i] >= limits.upper[i]))
                rows.col(i).setZero();
        LeastNorm shortest;
        shortest.factorize(rows);
        VectorX nearer = x - shortest.solve(goal);
        limits.clamp(nearer);
        LeastSquares::Values there;
        problem.evaluate(nearer, there);
        if (!(there.sides.maxCoeff() < values.sides.maxCoeff()))
            return;
        x = nearer;
        values = there;
    }
}

double violation_of(const LeastSquares::Values& values)
{
    return values.sides.size() > 0 ? values.sides.cwiseMax(0.0).sum() : 0.0;
}

} // namespace

void VariableLimits::clamp(VectorX& x) const
{
    x = x.cwiseMax(lower).cwiseMin(upper);
    for (const Ball& ball : balls) {
        const double length = x.segment<3>(ball.first).norm();
        if (length > ball.radius)
            x.segment<3>(ball.first) *= ball.radius / length;
        // Rounding may leave it just outside.
        while (x.segment<3>(ball.first).norm() > ball.radius)
            x.segment<3>(ball.first) *= 1 - std::numeric_limits<double>::epsilon();
    }
}

GaussNewtonReport minimize(LeastSquares& problem, const VariableLimits& limits, VectorX& x,
                           const GaussNewtonOptions& options)
{
    GaussNewtonReport report;
    limits.clamp(x);
    LeastSquares::Values values, next, bent;
    LeastSquares::Slopes slopes;
    problem.evaluate(x, values);
    VectorX multipliers = VectorX::Zero(values.sides.size());
    double damping = options.damping, price = 0.0;
    // At first, steps without curvature come closer. Where they fail, they would do so again.
    bool far = true;
    bool stuck = x.size() == 0;
    while (!stuck && !report.converged && report.iterations < options.max_iterations) {
        problem.linearize(multipliers, slopes);
        Model model(values, slopes, limits, x, multipliers);
        bool accepted = false;
        while (!accepted && damping < most_damping) {
            model.solve(damping, far);
            if (model.multipliers().size() > 0)
                price = std::min(most_price, std::max(price, 2 * model.multipliers().cwiseAbs().maxCoeff()));
            const auto merit = [&](const VectorX& at, LeastSquares::Values& found) {
                problem.evaluate(at, found);
                return found.squares + price * violation_of(found);
            };
            const double before = values.squares + price * violation_of(values),
                         predicted = model.predicted() + price * violation_of(values);
            VectorX trial = x + model.step();
            limits.clamp(trial);
            double after = merit(trial, next), share = 1.0;
            const VectorX bend = model.bent_step(next, damping) - model.step();
            // The curve x + t step + t^2 bend, from its end to its beginning.
            for (int k = 0; k < 4 && !(before - after > 0.5 * share * predicted); ++k) {
                const double t = std::ldexp(1.0, -k);
                VectorX nearer = x + t * model.step() + t * t * bend;
                limits.clamp(nearer);
                if (const double there = merit(nearer, bent); there < after) {
                    std::swap(trial, nearer);
                    std::swap(next, bent);
                    after = there;
                    share = t;
                }
            }
            const double drop = before - after, moved = (trial - x).cwiseAbs().maxCoeff();
            accepted = drop > 0;
            if (model.is_without_curvature() && drop < 0.25 * predicted)
                far = false;
            if (!accepted) {
                if (moved < 1e-12) { // no step is short enough to win anything but rounding
                    report.converged = true;
                    break;
                }
                ++report.rejected;
                damping = std::max(10 * damping, 1e-9);
                continue;
            }
            const double gain = drop / std::max(predicted, std::numeric_limits<double>::min());
            if (share == 1.0 && gain > 0.75)
                damping = std::max(damping / (gain > 0.9 ? 10 : 3), least_damping);
            else if (gain < 0.25 || share < 1.0)
                damping *= share < 0.5 ? 4 : 2;
            ++report.iterations;
            x = trial;
            problem.evaluate(x, values); // which linearize() looks at
            multipliers = model.multipliers().cwiseMax(0.0);
            const bool rests = drop <= options.tolerance * after || drop <= options.floor || moved < 1e-12;
            report.converged = rests && damping <= 1e-2 && violation_of(values) < 1e-9;
        }
        stuck = !accepted;
    }
    if (values.sides.size() > 0 && x.size() > 0)
        move_inside(problem, limits, x, values, slopes);
    problem.evaluate(x, values);
    report.squares = values.squares;
    report.violation = values.sides.size() > 0 ? std::max(0.0, values.sides.maxCoeff()) : 0.0;
    return report;
}

} // namespace sinew
