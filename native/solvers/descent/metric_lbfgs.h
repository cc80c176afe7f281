// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/report.h"
#include "native/core/types.h"

#include <memory>

namespace sinew {

/// A smooth function F >= 0 of (n, 3) unknowns whose Hessian is bounded by a fixed matrix L:
/// the step x - L^-1 g never overshoots by more than the model's own hidden state does.
class MetricProblem
{
public:
    virtual ~MetricProblem() = default;

    /// F(x), and its gradient. May move hidden state that F depends on (fitted rotations).
    virtual double evaluate(const Points& x, Points& gradient) = 0;

    /// z = L^-1 g.
    virtual void precondition(const Points& gradient, Points& z) const = 0;

    /// Keeps the hidden state, and brings it back after a rejected step.
    virtual void keep_state() = 0;
    virtual void restore_state() = 0;
};

struct LbfgsOptions
{
    int max_iterations = 40;  ///< trial steps, rejected ones included
    double tolerance = 1e-4;  ///< stop after two relative decreases in a row below this
    double floor = 0.0;       ///< stop when F is below this
    int window = 5;           ///< correction pairs, 16 at most
};

/// What minimize() works in. Kept from one call to the next, it spares the time to allocate it.
struct LbfgsWorkspace
{
    class History;

    LbfgsWorkspace();
    ~LbfgsWorkspace();
    LbfgsWorkspace(LbfgsWorkspace&&) noexcept;

    Points g, z, trial, trial_g, trial_z;
    std::unique_ptr<History> history;
};

/// L-BFGS with L^-1 as initial inverse Hessian.
///
/// J. Nocedal. "Updating Quasi-Newton Matrices with Limited Storage." 1980; the metric after
/// T. Liu, S. Bouaziz, L. Kavan. "Quasi-Newton Methods for Real-Time Simulation of Hyperelastic
/// Materials." 2017.
///
/// Keeps s and L^-1 y for each pair, so one application of L^-1 an iteration is enough, and their inner
/// products, so that two passes over them are; in single precision, as they only shape the steps. Each
/// step passes an Armijo test with up to three trials; then the plain step x - L^-1 g is taken
/// and the history dropped. A plain step that raises F ends the iteration: no accepted step
/// raises F.
///
/// \param[in,out] x  (n, 3) start in, best point out.
/// \param work       of any earlier call; null for its own.
/// \return iterations (trials), rejected, energy = F, residual = last relative decrease, converged.
SolveReport minimize(MetricProblem& problem, Points& x, const LbfgsOptions& options,
                     const Progress& progress = {}, LbfgsWorkspace* work = nullptr);

} // namespace sinew
