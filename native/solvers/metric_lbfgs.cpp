// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/metric_lbfgs.h"

#include "native/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

namespace sinew {

namespace {

constexpr int most_trials = 3;
constexpr double armijo = 1e-4;
/// Relative rise of F that is rounding, not ascent.
constexpr double rounding = 1e-12;
/// Of s.y, relative to |s| |y|: below, rounding to single precision could turn its sign.
constexpr double least_curvature = 1e-6;

constexpr int grain = 4096; ///< rows a parallel chunk: its vectors stay in the cache between two loops

/// Sums over the entries of two vectors, each by several counters side by side.
template <class A, class B>
double dot(const A* a, const B* b, int count)
{
    constexpr int width = 8;
    double sums[width] = {};
    int k = 0;
    for (; k + width <= count; k += width)
        for (int j = 0; j < width; ++j)
            sums[j] += static_cast<double>(a[k + j]) * static_cast<double>(b[k + j]);
    for (; k < count; ++k)
        sums[0] += static_cast<double>(a[k]) * static_cast<double>(b[k]);
    return ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
}

/// The last correction pairs, in single precision: s, y and L^-1 y. The recursion runs on their inner
/// products alone, so that an iteration reads each of them twice.
class History
{
public:
    History(int window, Eigen::Index numbers) : window_(window), numbers_(static_cast<int>(numbers)) {}

    int size() const { return size_; }
    void clear() { size_ = 0; }

    /// Takes in the pair from (x, g, z) to (x1, g1, z1), unless its curvature is not positive.
    void extend(const Points& x, const Points& x1, const Points& g, const Points& g1, const Points& z,
                const Points& z1)
    {
        if (window_ == 0)
            return;
        if (size_ == window_) { // the oldest goes
            std::rotate(pairs_.begin(), pairs_.begin() + 1, pairs_.begin() + size_);
            --size_;
        }
        if (static_cast<int>(pairs_.size()) == size_)
            pairs_.push_back(std::make_unique<Pair>(numbers_, window_));
        Pair& fresh = at(size_);
        enum { ss, yy, sy, y_Ly, s_g, y_z, fresh_sums };
        const std::vector<double> sums =
            gather(fresh_sums + 2 * size_, [&](int begin, int count, double* sums) {
                float *s = fresh.s.get() + begin, *y = fresh.y.get() + begin, *Ly = fresh.Ly.get() + begin;
                for (int k = 0; k < count; ++k) {
                    s[k] = static_cast<float>(x1.data()[begin + k] - x.data()[begin + k]);
                    y[k] = static_cast<float>(g1.data()[begin + k] - g.data()[begin + k]);
                    Ly[k] = static_cast<float>(z1.data()[begin + k] - z.data()[begin + k]);
                }
                sums[ss] = dot(s, s, count);
                sums[yy] = dot(y, y, count);
                sums[sy] = dot(s, y, count);
                sums[y_Ly] = dot(y, Ly, count);
                sums[s_g] = dot(s, g1.data() + begin, count);
                sums[y_z] = dot(y, z1.data() + begin, count);
                for (int k = 0; k < size_; ++k) {
                    sums[fresh_sums + 2 * k] = dot(at(k).s.get() + begin, g1.data() + begin, count);
                    sums[fresh_sums + 2 * k + 1] = dot(at(k).y.get() + begin, z1.data() + begin, count);
                }
            });
        // What changed between g and g1 is y of the new pair.
        for (int k = 0; k < size_; ++k) {
            at(k).later_s_y[size_ - k] = sums[fresh_sums + 2 * k] - at(k).s_g;
            at(k).later_y_Ly[size_ - k] = sums[fresh_sums + 2 * k + 1] - at(k).y_z;
            at(k).s_g = sums[fresh_sums + 2 * k];
            at(k).y_z = sums[fresh_sums + 2 * k + 1];
        }
        if (!(sums[sy] > least_curvature * std::sqrt(sums[ss] * sums[yy])))
            return;
        fresh.s_g = sums[s_g];
        fresh.y_z = sums[y_z];
        fresh.later_s_y[0] = sums[sy];
        fresh.later_y_Ly[0] = sums[y_Ly];
        ++size_;
    }

    /// d = H g by the two-loop recursion, with z = L^-1 g in place of a solve in its middle: the shares of
    /// s and L^-1 y that it adds to z.
    void recur()
    {
        for (int k = size_ - 1; k >= 0; --k) {
            double s_q = at(k).s_g;
            for (int j = k + 1; j < size_; ++j)
                s_q -= at(j).share_Ly * at(k).later_s_y[j - k];
            at(k).share_Ly = s_q / at(k).later_s_y[0];
        }
        for (int k = 0; k < size_; ++k) {
            double y_r = at(k).y_z;
            for (int j = 0; j < size_; ++j)
                y_r -= at(j).share_Ly * at(std::min(j, k)).later_y_Ly[std::abs(j - k)];
            for (int j = 0; j < k; ++j)
                y_r += at(j).share_s * at(j).later_s_y[k - j];
            at(k).share_s = at(k).share_Ly - y_r / at(k).later_s_y[0];
        }
    }

    /// trial = x - t d, and the slope g.d.
    double step(const Points& x, const Points& g, const Points& z, double t, Points& trial) const
    {
        trial.resize(x.rows(), 3);
        return gather(1, [&](int begin, int count, double* sums) {
            double* const d = trial.data() + begin;
            std::copy_n(z.data() + begin, count, d);
            for (int k = 0; k < size_; ++k) {
                const float *s = at(k).s.get() + begin, *Ly = at(k).Ly.get() + begin;
                const double share_s = at(k).share_s, share_Ly = at(k).share_Ly;
                for (int j = 0; j < count; ++j)
                    d[j] += share_s * s[j] - share_Ly * Ly[j];
            }
            sums[0] = dot(d, g.data() + begin, count);
            for (int j = 0; j < count; ++j)
                d[j] = x.data()[begin + j] - t * d[j];
        })[0];
    }

private:
    struct Pair
    {
        Pair(int numbers, int window)
            : s(new float[numbers]), y(new float[numbers]), Ly(new float[numbers]), later_s_y(window),
              later_y_Ly(window)
        {
        }
        std::unique_ptr<float[]> s, y, Ly; ///< step, change of the gradient, L^-1 y
        double s_g = 0.0, y_z = 0.0;       ///< with the present g and z
        /// Its s with the y, and its y with the L^-1 y, of itself and of the pairs after it.
        std::vector<double> later_s_y, later_y_Ly;
        double share_s = 0.0, share_Ly = 0.0;
    };

    Pair& at(int k) { return *pairs_[k]; }
    const Pair& at(int k) const { return *pairs_[k]; }

    /// Sums of `count` numbers that body(begin, count, sums) finds in each chunk, in a fixed order.
    template <class Body>
    std::vector<double> gather(int count, const Body& body) const
    {
        const int chunks = (numbers_ + grain - 1) / grain;
        std::vector<double> parts(static_cast<std::size_t>(chunks) * count), total(count, 0.0);
        parallel_chunks(numbers_, grain, [&](int begin, int end) {
            body(begin, end - begin, parts.data() + static_cast<std::size_t>(begin / grain) * count);
        });
        for (int chunk = 0; chunk < chunks; ++chunk)
            for (int k = 0; k < count; ++k)
                total[k] += parts[static_cast<std::size_t>(chunk) * count + k];
        return total;
    }

    int window_, numbers_, size_ = 0;
    std::vector<std::unique_ptr<Pair>> pairs_; ///< those in use first, oldest first
};

} // namespace

SolveReport minimize(MetricProblem& problem, Points& x, const LbfgsOptions& options, const Progress& progress)
{
    SolveReport report;
    Points g, z, trial, trial_g, trial_z;
    History history(options.window, x.size());
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
        history.recur();
        problem.keep_state();

        double F_trial = F;
        bool accepted = false;
        double t = 1.0;
        for (int k = 0; k < most_trials && history.size() > 0; ++k) {
            const double slope = history.step(x, g, z, t, trial);
            if (!(slope > 0))
                break;
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
            history.clear();
            history.step(x, g, z, 1.0, trial);
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
            history.extend(x, trial, g, trial_g, z, trial_z);
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
