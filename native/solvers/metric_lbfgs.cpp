// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/metric_lbfgs.h"

#include "native/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

namespace sinew {

namespace {

constexpr int most_trials = 3;
constexpr double armijo = 1e-4;
/// Relative rise of F that is rounding, not ascent.
constexpr double rounding = 1e-12;

double dot(const Points& a, const Points& b)
{
    return parallel_sum(static_cast<int>(a.rows()), [&](int i) { return a.row(i).dot(b.row(i)); }, 8192);
}

struct Pair
{
    Points s;  ///< step
    Points y;  ///< change of the gradient
    Points Ly; ///< L^-1 y
    double rho;
};

/// H g by the two-loop recursion, with z = L^-1 g in place of a solve in its middle.
Points direction(const std::deque<Pair>& pairs, const Points& g, const Points& z)
{
    if (pairs.empty())
        return z;
    Points q = g;
    Points r = z;
    std::vector<double> alpha(pairs.size());
    for (std::size_t k = pairs.size(); k-- > 0;) {
        alpha[k] = pairs[k].rho * dot(pairs[k].s, q);
        q -= alpha[k] * pairs[k].y;
        r -= alpha[k] * pairs[k].Ly;
    }
    for (std::size_t k = 0; k < pairs.size(); ++k)
        r += (alpha[k] - pairs[k].rho * dot(pairs[k].y, r)) * pairs[k].s;
    return r;
}

} // namespace

SolveReport minimize(MetricProblem& problem, Points& x, const LbfgsOptions& options, const Progress& progress)
{
    SolveReport report;
    Points g, z, trial, trial_g, trial_z;
    std::deque<Pair> pairs;
    int small_steps = 0;

    double F = problem.evaluate(x, g);
    const auto done = [&] {
        report.converged = report.converged || F <= options.floor || small_steps >= 2;
        return report.converged || report.iterations >= options.max_iterations;
    };
    if (!done())
        problem.precondition(g, z);
    while (!done()) {
        progress.tick(static_cast<double>(report.iterations) / options.max_iterations, "solving");
        const Points d = direction(pairs, g, z);
        const double slope = dot(g, d);
        problem.keep_state();

        double F_trial = F;
        bool accepted = false;
        double t = 1.0;
        for (int k = 0; k < most_trials && !pairs.empty() && slope > 0; ++k) {
            trial = x - t * d;
            F_trial = problem.evaluate(trial, trial_g);
            ++report.iterations;
            accepted = F_trial <= F - armijo * t * slope;
            if (accepted || report.iterations >= options.max_iterations)
                break;
            ++report.rejected;
            problem.restore_state();
            const double parabola = slope * t * t / (2 * (F_trial - F + slope * t));
            t = std::clamp(parabola, 0.1 * t, 0.6 * t);
        }
        if (!accepted && report.iterations < options.max_iterations) {
            pairs.clear();
            trial = x - z;
            F_trial = problem.evaluate(trial, trial_g);
            ++report.iterations;
            accepted = F_trial <= F;
            // At the minimum the plain step moves within rounding.
            report.converged = !accepted && F_trial <= F + rounding * std::abs(F);
        }
        if (!accepted) {
            ++report.rejected;
            problem.restore_state();
            break;
        }

        report.residual = F > 0 ? (F - F_trial) / F : 0.0;
        small_steps = report.residual < options.tolerance ? small_steps + 1 : 0;
        if (report.iterations < options.max_iterations && small_steps < 2) {
            problem.precondition(trial_g, trial_z);
            Pair pair{trial - x, trial_g - g, trial_z - z, 0.0};
            const double curvature = dot(pair.s, pair.y);
            if (curvature > 1e-10 * std::sqrt(dot(pair.s, pair.s) * dot(pair.y, pair.y))) {
                pair.rho = 1.0 / curvature;
                pairs.push_back(std::move(pair));
                if (static_cast<int>(pairs.size()) > options.window)
                    pairs.pop_front();
            }
        }
        F = F_trial;
        std::swap(x, trial);
        std::swap(g, trial_g);
        std::swap(z, trial_z);
    }
    report.energy = F;
    return report;
}

} // namespace sinew
