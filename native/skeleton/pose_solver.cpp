// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/skeleton/pose_solver.h"

#include "native/core/errors.h"
#include "native/skeleton/pose_problem.h"
#include "native/solvers/dense/gauss_newton.h"

#include <algorithm>

namespace sinew {

PoseReport solve_pose(const Skeleton& skeleton, const PoseRequest& request, Posture& posture,
                      const PoseSolverOptions& options)
{
    require_at_least(options.rest, 0.0, "rest");
    require_at_least(options.pole, 0.0, "pole");
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
        do {
            const GaussNewtonReport steps =
                minimize(problem, problem.limits(), x,
                         {.max_iterations = options.max_iterations - report.iterations,
                          .tolerance = options.tolerance});
            report.iterations += steps.iterations;
            report.rejected += steps.rejected;
            report.converged = steps.converged;
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
