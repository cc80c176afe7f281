// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/report.h"
#include "native/core/types.h"

#include <memory>

namespace sinew {

/// A smooth function F >= 0 of (n, 3) unknowns whose Hessian is bounded by a fixed matrix L, so that a step
/// x - L^-1 g does not overshoot. F may also depend on a state, such as rotations that are fitted to x.
class MetricProblem
{
public:
    virtual ~MetricProblem() = default;

    /// F(x) and its gradient. May change the state.
    virtual double evaluate(const Points& x, Points& gradient) = 0;

    /// z = L^-1 g.
    virtual void precondition(const Points& gradient, Points& z) const = 0;

    /// Keeps a copy of the state, and restores it after a rejected step.
    virtual void keep_state() = 0;
    virtual void restore_state() = 0;

    /// Optional coarse step from an accepted point, multiplicative: where it lowers F, moves x, and F and its
    /// gradient with it, and changes the state.
    /// \return whether it has moved x.
    virtual bool improve(Points& x, Points& gradient, double& F);

    /// Optional end of a descent: x and the state go on by a share of the way that they came since the state
    /// was kept at `from`, unless F were no lower than it was there. The gradient becomes that of the new x.
    /// \return whether it has moved x.
    virtual bool go_on(const Points& from, double F_from, double share, Points& x, Points& gradient,
                       double& F);

    /// Moves a trial point onto the constraints of the problem, for example to a given volume. Such a problem
    /// gives the gradient along its constraints.
    /// \return whether the point has moved.
    virtual bool admit(Points&) { return false; }
};

struct LbfgsOptions
{
    int max_iterations = 40;  ///< trial steps, rejected ones included
    double tolerance = 1e-4; ///< stop when the relative decrease of F is below this twice in succession
    /// If not 0, stop instead when no row of x has more than `tolerance` times this left to go: an estimate,
    /// by the longest way of a row in the last iteration and in the one before. At the end go_on() is asked
    /// to take what slow parts have left.
    double size = 0.0;
    double floor = 0.0; ///< stop when F is below this
    int window = 5; ///< number of correction pairs, at most 16
    /// How many plain steps are tried before the end, of lengths 1, 0.3, 0.09, ... One is enough where L
    /// bounds the Hessian.
    int plain_steps = 1;
};

/// The workspace of minimize(). If it is kept from one call to the next, it is not allocated again.
struct LbfgsWorkspace
{
    class History;

    LbfgsWorkspace();
    ~LbfgsWorkspace();
    LbfgsWorkspace(LbfgsWorkspace&&) noexcept;

    Points g, z, trial, trial_g, trial_z, way;
    std::unique_ptr<History> history;
};

/// L-BFGS with L^-1 as initial inverse Hessian.
///
/// J. Nocedal. "Updating Quasi-Newton Matrices with Limited Storage." 1980; the metric after
/// T. Liu, S. Bouaziz, L. Kavan. "Quasi-Newton Methods for Real-Time Simulation of Hyperelastic
/// Materials." 2017.
///
/// The history keeps s and L^-1 y for each correction pair, so that an iteration applies L^-1 only once. It
/// also keeps their inner products, so that an iteration reads the pairs only twice. The pairs are in single
/// precision, as they affect the direction of the steps only. A step must pass an Armijo test and has up to
/// three trials. If all fail, the plain step x - L^-1 g is taken and the history is cleared. If all plain
/// steps raise F, too, the iteration ends, so no accepted step ever raises F.
///
/// \param[in,out] x  (n, 3) the start at first, the best point afterwards.
/// \param work       the workspace of an earlier call; null for a new one.
/// \return iterations (trials), rejected, energy = F, converged, residual = the last relative decrease, or
///         what is left to go as a share of the size.
SolveReport minimize(MetricProblem& problem, Points& x, const LbfgsOptions& options,
                     const Progress& progress = {}, LbfgsWorkspace* work = nullptr);

} // namespace sinew
