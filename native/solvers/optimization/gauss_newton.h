// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <vector>

namespace sinew {

/// A sum of squares of some hundred unknowns at most, with sides: inequalities c(x) <= 0.
///
///     F(x) = 1/2 |r(x)|^2 + 1/2 sum_i k_i (x_i - b_i)^2
class LeastSquares
{
public:
    virtual ~LeastSquares() = default;

    struct Values
    {
        double squares = 0.0; ///< F
        VectorX residuals; ///< r
        VectorX sides; ///< c; always as many
    };
    struct Slopes
    {
        VectorX gradient;  ///< of F
        MatrixX rows;      ///< (residuals, n) J, the derivative of r
        VectorX diagonal;  ///< (n) k
        MatrixX curvature; ///< (n, n) what the second derivatives of r, and of the sides, add to J^T J
        MatrixX sides;     ///< (sides, n) the gradients of c
    };

    virtual void evaluate(const VectorX& x, Values& values) = 0;
    /// At the x that was evaluated last.
    /// \param multipliers  (sides) estimates of the Lagrange multipliers.
    virtual void linearize(const VectorX& multipliers, Slopes& slopes) = 0;
};

/// The region in which the unknowns have to stay.
struct VariableLimits
{
    /// Three unknowns from `first` on, whose norm is at most `radius`.
    struct Ball
    {
        int first;
        double radius;
    };

    VectorX lower, upper; ///< (n) of each unknown; may be infinite
    std::vector<Ball> balls;

    void clamp(VectorX& x) const;
};

struct GaussNewtonOptions
{
    int max_iterations = 60; ///< accepted steps
    /// Stop when a step lowers F by at most this share of F, or by less than `floor`.
    double tolerance = 1e-9;
    double floor = 1e-26;
    double damping = 1e-3; ///< of the first step
};

struct GaussNewtonReport
{
    int iterations = 0; ///< accepted steps
    int rejected = 0;   ///< trial steps that were not accepted
    double squares = 0.0; ///< F
    double violation = 0.0; ///< the largest c, at least 0
    bool converged = false;
};

/// Damped Gauss-Newton steps within limits.
///
/// K. Levenberg. "A Method for the Solution of Certain Non-Linear Problems in Least Squares." 1944.
/// J. Nocedal, S. Wright. "Numerical Optimization." 2006, chapters 10, 16 and 18: active sets, and the merit
/// function F + mu sum max(0, c).
/// M. Transtrum, J. Sethna. "Improvements to the Levenberg-Marquardt algorithm for nonlinear least-squares
/// minimization." 2012: geodesic acceleration.
///
/// A step minimises the quadratic model of F under the linear models of the active sides. An unknown at its
/// bound does not move outward, and three at the border of their ball move along it; a side is active if the
/// step would violate it. What a step leaves outside of bounds and balls is clamped, so no x outside of them
/// is ever evaluated. Where the curvature keeps the matrix of the step positive definite, it is added: then
/// the last steps converge quadratically also where F is not near zero. A second solve with the same factor
/// takes in how r and c bend along the step, without which steps along a narrow valley would be short. The
/// better of the two steps is taken, and no accepted step raises the merit.
///
/// Cost of a step: n^3 / 3 operations per trial and change of the active set.
///
/// \param[in,out] x  the start, which is clamped at first; the best point afterwards.
GaussNewtonReport minimize(LeastSquares& problem, const VariableLimits& limits, VectorX& x,
                           const GaussNewtonOptions& options = {});

} // namespace sinew
