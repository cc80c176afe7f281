// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/local_global/arap/arap_problem.h"
#include "native/local_global/arap/arap_system.h"
#include "native/solvers/optimization/metric_lbfgs.h"
#include "native/solvers/single_factor.h"

#include <vector>

namespace sinew {

/// As-rigid-as-possible deformation whose surface is also smooth where a single vertex is held.
///
/// A. Oehri, P. Herholz, O. Sorkine-Hornung. "Higher Order Continuity for Smooth As-Rigid-As-Possible Shape
/// Modeling." 2025.
///
/// With F = E / 4 of as-rigid-as-possible deformation (cells of edges), its gradient r = L q - b(R) at all
/// nodes, held ones included, and masses M whose mean is 1, the positions minimise
///
///     (1 - lambda) F(q, R) + lambda / 2 sum_i |r_i|^2 / m_i
///
/// for given rotations: their system is A = lambda L M^-1 L + (1 - lambda) L. The rotations are those of F,
/// fitted to the edges alone.
class HigherOrder
{
public:
    /// \param lambda  in (0, 1)
    /// \param mass    (nodes) > 0
    /// \throw FactorizationFailed
    HigherOrder(const ArapSystem& graph, double lambda, std::vector<double> mass);

    double lambda() const { return lambda_; }
    double mass(int node) const { return mass_[node]; }
    /// (nodes, nodes) L
    const SparseMatrix& laplacian() const { return laplacian_; }
    const SingleFactor& factor() const { return factor_; }

private:
    double lambda_;
    std::vector<double> mass_;
    SparseMatrix laplacian_;
    SingleFactor factor_;
};

/// The energy above as a function of the free positions. As the rotations do not minimise all of it, the
/// gradient is that for given rotations.
class HigherOrderProblem final : public MetricProblem
{
public:
    /// \param base   (nodes, 3), as that of `problem`.
    /// \param pulls  (pulls, 3), likewise.
    HigherOrderProblem(const ArapSystem& graph, const HigherOrder& order, ArapProblem& problem,
                       const PointsView& base, const Points& pulls);

    /// The free positions for the present rotations.
    /// \param[in,out] x  any positions at first
    void global_step(Points& x);

    double evaluate(const Points& x, Points& gradient) override;
    void precondition(const Points& gradient, Points& z) const override
    {
        order_.factor().solve(gradient, z);
    }
    void keep_state() override { problem_.keep_state(); }
    void restore_state() override { problem_.restore_state(); }

private:
    /// lambda / 2 sum |r|^2 / m, and the gradient of all for the present rotations.
    double bend(const Points& x, Points& gradient);

    const ArapSystem& graph_;
    const HigherOrder& order_;
    ArapProblem& problem_;
    PointsView base_;
    const Points& pulls_;
    Points r_;
};

} // namespace sinew
