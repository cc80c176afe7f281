// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/skeleton/pose_solver.h"

#include "native/core/errors.h"
#include "native/skeleton/pose_problem.h"
#include "native/solvers/optimization/gauss_newton.h"

#include <algorithm>

namespace sinew {

namespace {

/// The weights of `rest` on the way to the one asked for.
constexpr double stiff_first[] = {1e-2, 3e-3, 1e-3};
constexpr double roughly = 1e-2; ///< the tolerance on the way

} // namespace

PoseReport solve_pose(const Skeleton& skeleton, const PoseRequest& request, Posture& posture,
                      const PoseSolverOptions& options)
{
    require_at_least(options.rest, 0.0, "rest");
    require_at_least(options.pole, 0.0, "pole");
    require_at_least(options.swing, 0.0, "swing");
    require_at_least(options.max_iterations, 1, "max_iterations");
    require_at_least(options.tolerance, 0.0, "tolerance");
    PoseProblem problem(skeleton, request, options, request.base ? *request.base : skeleton.rest());
    LeastSquares::Values values;
    VectorX x = problem.base();
    problem.evaluate(x, values);
    const bool balanced = values.sides.size() == 0 || values.sides.maxCoeff() <= 0;
    PoseReport report;
    report.converged = true;
    if (values.squares > 1e-26 || !balanced) { // else all that is left is rounding
        x = problem.start();
        const auto steps_to = [&](double tolerance) {
            const GaussNewtonReport steps = minimize(
                problem, problem.limits(), x,
                {.max_iterations = options.max_iterations - report.iterations, .tolerance = tolerance});
            report.iterations += steps.iterations;
            report.rejected += steps.rejected;
            report.converged = steps.converged;
        };
        for (double rest : stiff_first)
            if (rest > options.rest && report.iterations < options.max_iterations) {
                problem.set_rest(rest);
                steps_to(roughly);
            }
        problem.set_rest(options.rest);
        do {
            steps_to(options.tolerance);
        } while (problem.unwind(x) && report.iterations < options.max_iterations);
        problem.evaluate(x, values);
    }
    posture = problem.posture(x);
    report.energy = values.squares;
    report.gaps = problem.gaps();
    report.centre = problem.centre();
    if (request.balance) {
        const Support support(request.balance->support, request.balance->up);
        for (int side = 0; side < support.side_count(); ++side)
            report.overhang = std::max(report.overhang, support.outside(side, report.centre));
    }
    return report;
}

} // namespace sinew
