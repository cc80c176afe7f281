// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/optimization/metric_lbfgs.h"

#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/solvers/optimization/kernels.h"

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
constexpr double shorter = 0.3; ///< a plain step than the one before
/// A relative rise of F that may come from rounding.
constexpr double rounding = 1e-12;
/// The least s.y / (|s| |y|) of a pair that is kept. Rounding to single precision could change the sign of a
/// smaller one.
constexpr double least_curvature = 1e-6;

/// The largest share of its way that an iteration is taken to leave to the next one.
constexpr double most_left = 0.9;
/// How many of the last ways go_on() goes on at least and at most, and what it leaves of what was left.
constexpr double least_on = 0.05, most_on = 1.5, left_by_going_on = 0.5;

constexpr int grain = 2048; ///< numbers per parallel chunk; its vectors stay in the cache between two loops
constexpr int most_window = 16;

/// How far the rows of x went in an iteration.
struct Way
{
    double longest = 0.0;
    double square = 0.0, along_last = 0.0; ///< of all rows: products with themselves and with the last ways

    /// \param[in,out] ways  the last ones, or none; replaced by these.
    Way(const Points& from, const Points& to, Points& ways)
    {
        const int rows = static_cast<int>(from.rows());
        const bool first = ways.rows() != rows;
        if (first)
            ways.resize(rows, 3);
        std::vector<Eigen::Vector3d> parts(rows / grain + 1, Eigen::Vector3d::Zero());
        parallel_chunks(rows, grain, [&](int begin, int end) {
            Eigen::Vector3d& part = parts[begin / grain];
            for (int i = begin; i < end; ++i) {
                const Eigen::RowVector3d way = to.row(i) - from.row(i);
                const double square = way.squaredNorm();
                part[0] = std::max(part[0], square);
                part[1] += square;
                part[2] += first ? 0.0 : way.dot(ways.row(i));
                ways.row(i) = way;
            }
        });
        for (const Eigen::Vector3d& part : parts) {
            longest = std::max(longest, part[0]);
            square += part[1];
            along_last += part[2];
        }
        longest = std::sqrt(longest);
    }
};

} // namespace

/// The last correction pairs s and L^-1 y, in single precision. The recursion needs only their inner products
/// with each other and with the gradient, so an iteration reads each of them twice.
class LbfgsWorkspace::History
{
public:
    /// Removes all pairs.
    void reset(int window, Eigen::Index numbers)
    {
        if (numbers_ != numbers || window_ != window)
            pairs_.clear();
        window_ = window;
        numbers_ = static_cast<int>(numbers);
        size_ = 0;
        while (static_cast<int>(pairs_.size()) < window_ + (window_ > 0))
            pairs_.push_back(std::make_unique<Pair>(numbers_, window_));
    }

    int size() const { return size_; }
    void clear() { size_ = 0; }

    /// Adds the pair of the last step(), which changed (g, z) to (g1, z1), unless its curvature is too small.
    void extend(const Points& g, const Points& g1, const Points& z, const Points& z1)
    {
        if (window_ == 0)
            return;
        if (size_ == window_) { // the oldest pair makes room
            std::rotate(pairs_.begin(), pairs_.begin() + 1, pairs_.end());
            --size_;
        }
        Pair& fresh = at(size_);
        const int chunks = (numbers_ + grain - 1) / grain;
        parts_.resize(chunks);
        older_.resize(static_cast<std::size_t>(2 * size_) * chunks);
        parallel_chunks(numbers_, grain, [&](int begin, int end) {
            const int chunk = begin / grain, count = end - begin;
            parts_[chunk] =
                kernels_.pair(g.data() + begin, g1.data() + begin, z.data() + begin, z1.data() + begin,
                              fresh.s.get() + begin, count, fresh.Ly.get() + begin);
            const float *s[most_window], *Ly[most_window];
            collect(begin, s, Ly);
            kernels_.products(g1.data() + begin, size_, s, Ly, count,
                              older_.data() + static_cast<std::size_t>(2 * size_) * chunk);
        });
        PairProducts sums{};
        for (const PairProducts& part : parts_) {
            sums.ss += part.ss, sums.yy += part.yy, sums.sy += part.sy, sums.y_Ly += part.y_Ly;
            sums.s_g += part.s_g, sums.Ly_g += part.Ly_g, sums.z_g += part.z_g;
        }
        z_g_ = sums.z_g;
        // g1 - g is y of the new pair, so its products are differences of those with g1 and with g.
        for (int k = 0; k < size_; ++k) {
            double s_g = 0.0, Ly_g = 0.0;
            for (int chunk = 0; chunk < chunks; ++chunk) {
                s_g += older_[static_cast<std::size_t>(2 * size_) * chunk + 2 * k];
                Ly_g += older_[static_cast<std::size_t>(2 * size_) * chunk + 2 * k + 1];
            }
            at(k).later_s_y[size_ - k] = s_g - at(k).s_g;
            at(k).later_y_Ly[size_ - k] = Ly_g - at(k).Ly_g;
            at(k).s_g = s_g;
            at(k).Ly_g = Ly_g;
        }
        if (!(sums.sy > least_curvature * std::sqrt(sums.ss * sums.yy)))
            return;
        fresh.s_g = sums.s_g;
        fresh.Ly_g = sums.Ly_g;
        fresh.later_s_y[0] = sums.sy;
        fresh.later_y_Ly[0] = sums.y_Ly;
        ++size_;
    }

    /// The two-loop recursion for d = H g, in inner products: computes the shares of s and L^-1 y that have
    /// to be added to z = L^-1 g.
    /// \return the slope g.d
    double recur()
    {
        for (int k = size_ - 1; k >= 0; --k) {
            double s_q = at(k).s_g;
            for (int j = k + 1; j < size_; ++j)
                s_q -= at(j).share_Ly * at(k).later_s_y[j - k];
            at(k).share_Ly = s_q / at(k).later_s_y[0];
        }
        double slope = z_g_;
        for (int k = 0; k < size_; ++k) {
            double y_r = at(k).Ly_g; // y.z
            for (int j = 0; j < size_; ++j)
                y_r -= at(j).share_Ly * at(std::min(j, k)).later_y_Ly[std::abs(j - k)];
            for (int j = 0; j < k; ++j)
                y_r += at(j).share_s * at(j).later_s_y[k - j];
            at(k).share_s = at(k).share_Ly - y_r / at(k).later_s_y[0];
            slope += at(k).share_s * at(k).s_g - at(k).share_Ly * at(k).Ly_g;
        }
        return slope;
    }

    /// trial = x - t d. The step becomes s of the next pair.
    void step(const Points& x, const Points& z, double t, Points& trial)
    {
        trial.resize(x.rows(), 3);
        std::vector<double> share_s(size_), share_Ly(size_);
        for (int k = 0; k < size_; ++k) {
            share_s[k] = at(k).share_s;
            share_Ly[k] = at(k).share_Ly;
        }
        parallel_chunks(numbers_, grain, [&](int begin, int end) {
            const float *s[most_window], *Ly[most_window];
            collect(begin, s, Ly);
            kernels_.step(x.data() + begin, z.data() + begin, size_, s, Ly, share_s.data(), share_Ly.data(),
                          t, end - begin, trial.data() + begin,
                          window_ > 0 ? at(size_).s.get() + begin : nullptr);
        });
    }

    /// The trial of step() has been moved: makes the way to it s of the next pair.
    void moved(const Points& x, const Points& trial)
    {
        if (window_ > 0)
            parallel_for(numbers_, [&, s = at(size_).s.get()](int i) {
                s[i] = static_cast<float>(trial.data()[i] - x.data()[i]);
            });
    }

private:
    struct Pair
    {
        Pair(int numbers, int window)
            : s(new float[numbers]), Ly(new float[numbers]), later_s_y(window), later_y_Ly(window)
        {
        }
        std::unique_ptr<float[]> s, Ly; ///< the step, and L^-1 y for the change y of the gradient
        double s_g = 0.0, Ly_g = 0.0; ///< their products with the present g
        /// The products of s and of L^-1 y with y of this pair and of those after it.
        std::vector<double> later_s_y, later_y_Ly;
        double share_s = 0.0, share_Ly = 0.0;
    };

    Pair& at(int k) { return *pairs_[k]; }

    /// Pointers to the vectors of all pairs, from number `begin` on.
    void collect(int begin, const float** s, const float** Ly)
    {
        for (int k = 0; k < size_; ++k) {
            s[k] = at(k).s.get() + begin;
            Ly[k] = at(k).Ly.get() + begin;
        }
    }

    const LbfgsKernels& kernels_ = widest_kernels<LbfgsKernels>();
    int window_ = 0, numbers_ = 0, size_ = 0;
    double z_g_ = 0.0; ///< product of the present z and g
    std::vector<std::unique_ptr<Pair>> pairs_; ///< the pairs in use, oldest first; then one for the next step
    std::vector<PairProducts> parts_;
    std::vector<double> older_;
};

LbfgsWorkspace::LbfgsWorkspace() : history(std::make_unique<History>()) {}
LbfgsWorkspace::~LbfgsWorkspace() = default;
LbfgsWorkspace::LbfgsWorkspace(LbfgsWorkspace&&) noexcept = default;

bool MetricProblem::improve(Points&, Points&, double&) { return false; }
bool MetricProblem::go_on(const Points&, double, double, Points&, Points&, double&) { return false; }

SolveReport minimize(MetricProblem& problem, Points& x, const LbfgsOptions& options, const Progress& progress,
                     LbfgsWorkspace* work)
{
    if (!work) {
        LbfgsWorkspace own;
        return minimize(problem, x, options, progress, &own);
    }
    SolveReport report;
    auto& [g, z, trial, trial_g, trial_z, ways, kept] = *work;
    LbfgsWorkspace::History& history = *kept;
    history.reset(std::min(options.window, most_window), x.size());
    int small_steps = 0;
    bool settled = false;
    double last_way = 0.0, last_square = 0.0;
    ways.resize(0, 3);

    double F = problem.evaluate(x, g);
    const auto try_step = [&](double t) {
        history.step(x, z, t, trial);
        if (problem.admit(trial))
            history.moved(x, trial);
        ++report.iterations;
        return problem.evaluate(trial, trial_g);
    };
    const auto done = [&] {
        report.converged = report.converged || F <= options.floor || settled;
        return report.converged || report.iterations >= options.max_iterations;
    };
    if (!done()) {
        if (options.size > 0)
            trial = x;
        if (problem.improve(x, g, F) && options.size > 0) {
            const Way way(trial, x, ways);
            last_way = way.longest;
            last_square = way.square;
        }
        problem.precondition(g, z);
    }
    while (!done()) {
        progress.tick(static_cast<double>(report.iterations) / options.max_iterations, "solving");
        const double slope = history.recur();
        problem.keep_state();

        double F_trial = F;
        bool accepted = false;
        double t = 1.0;
        for (int k = 0;
             !accepted && report.iterations < options.max_iterations && k < most_trials && history.size() > 0;
             ++k) {
            if (!(slope > 0))
                break;
            F_trial = try_step(t);
            accepted = F_trial <= F - armijo * t * slope;
            if (accepted || report.iterations >= options.max_iterations)
                break;
            ++report.rejected;
            problem.restore_state();
            const double parabola = slope * t * t / (2 * (F_trial - F + slope * t));
            t = std::clamp(parabola, 0.1 * t, 0.6 * t);
        }
        t = 1.0;
        for (int k = 0; k < options.plain_steps && !accepted && report.iterations < options.max_iterations;
             ++k) {
            if (k == 0) {
                history.clear();
            } else {
                ++report.rejected;
                problem.restore_state();
                t *= shorter;
            }
            F_trial = try_step(t);
            accepted = F_trial < F;
            // At the minimum, the plain step changes F by rounding only, or not at all.
            report.converged = !accepted && F_trial <= F + rounding * std::abs(F);
            if (report.converged)
                break;
        }
        if (!accepted) {
            ++report.rejected;
            problem.restore_state();
            break;
        }

        const bool improved = problem.improve(trial, trial_g, F_trial);
        if (improved)
            history.moved(x, trial);
        if (options.size > 0) {
            const Way way(x, trial, ways);
            // As if ways shrink on as they did from the last iteration to this one. Slow parts show late, the
            // more so where no coarse step moves them.
            const double kept = last_way > 0 ? std::min(way.longest / last_way, most_left) : most_left;
            const auto left = [&](double share) {
                return way.longest * std::max(improved ? 1.0 : 2.0, share * kept / (1 - kept)) / options.size;
            };
            report.residual = left(1.0);
            const double slow = last_square > 0 ? way.along_last / last_square : 0.0;
            const double on = slow < 1 ? std::min(slow / (1 - slow), most_on) : most_on;
            if (on > least_on && left(left_by_going_on) < options.tolerance &&
                problem.go_on(x, F, on, trial, trial_g, F_trial))
                report.residual = left(left_by_going_on);
            settled = report.residual < options.tolerance;
            last_way = way.longest;
            last_square = way.square;
        } else {
            report.residual = F != 0 ? (F - F_trial) / std::abs(F) : 0.0;
            small_steps = report.residual < options.tolerance ? small_steps + 1 : 0;
            settled = small_steps >= 2;
        }
        if (report.iterations < options.max_iterations && !settled) {
            problem.precondition(trial_g, trial_z);
            history.extend(g, trial_g, z, trial_z);
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
