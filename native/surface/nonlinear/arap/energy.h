// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/solvers/descent/metric_lbfgs.h"
#include "native/surface/nonlinear/arap/graph.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

namespace sinew {

/// The covariance of a chunk's i-th node, out of the lanes that the kernels leave it in.
inline auto arap_covariance(const double* S, int i)
{
    using Lanes = Eigen::Map<const Matrix3, 0, Eigen::OuterStride<arap_columns / 3>>;
    return Lanes(S + arap_columns * static_cast<std::size_t>(i));
}

/// What an ArapProblem works in. Kept from one solve to the next, it spares the time to allocate it.
struct ArapBuffers
{
    std::vector<double> base, points;       ///< three numbers a node
    std::vector<double> rotations[3]; ///< nine a node; with smoothing those kept, and two to work with
    std::vector<double> covariances; ///< with smoothing
    Points torque, gradient;
    std::vector<double> energies; ///< one a chunk
};

/// One solve's state on one graph: positions and rotations. F = E / energy_factor() as a
/// function of the free positions, the rotations being fitted on every evaluation.
class ArapProblem final : public MetricProblem
{
public:
    /// \param base     (size, 3) shape whose edges are kept as rigid as possible.
    /// \param targets  (size, 3) where held nodes go; base for the idle ones; else unused.
    /// \param pulls    (pulls, 3) where pulled nodes would go.
    /// \param buffers  of any earlier problem, in use while this one lives; null for its own.
    ArapProblem(const ArapGraph& graph, const PointsView& base, const Points& targets, const Points& pulls,
                ArapBuffers* buffers = nullptr);

    Matrix3 rotation(int i) const;
    /// Of a moving node, or before the first evaluation, which settles the others' for good.
    void set_rotation(int i, const Matrix3& R);

    /// Free positions that answer the current rotations: a linear solve, and one for what it left.
    void positions_for_rotations(Points& x);
    Points positions_for_rotations()
    {
        Points x;
        positions_for_rotations(x);
        return x;
    }
    /// Rotations that answer the positions cell by cell, neighbours ignored.
    void fit_rotations(const Points& x);

    double evaluate(const Points& x, Points& gradient) override;
    void precondition(const Points& gradient, Points& z) const override;
    /// Without smoothing rotations depend on the points alone: they are not kept, but fitted again.
    void keep_state() override { kept_ = graph_.is_smooth() ? current_ : -1; }
    void restore_state() override
    {
        if (graph_.is_smooth())
            current_ = kept_;
        else
            stale_ = true;
    }
    /// After restore_state(), with the points that were kept: their rotations for rotation() to tell.
    void refresh(const Points& x)
    {
        if (stale_)
            fit_rotations(x);
    }

    /// All nodes, the free ones at x.
    PointsView place(const Points& x);
    /// (free, 3) of an (n, 3) array.
    Points free_rows(const PointsView& all) const { return all.topRows(graph_.free_count()); }

private:
    using Matrices = std::vector<double>;

    void move_to(const Points& x);
    /// A set of rotations that neither the kept ones nor `used` occupy.
    int spare(int used) const;
    void for_each_moving(const std::function<void(const ArapChunk&)>& body) const;
    void fit(const ArapChunk& chunk, const double* S, const Matrices& before, double tie,
             Matrices& after) const;
    void settle_the_others();
    double* covariances_of(const ArapChunk& chunk) const;
    void turn_rotation_field();
    double energy_and_gradient(Points& gradient) const;

    const ArapGraph& graph_;
    const ArapKernels& kernels_;
    const Points& pulls_;
    std::unique_ptr<ArapBuffers> own_buffers_;
    ArapBuffers& buffers_;
    ArapView view_;
    int current_ = 0, kept_ = -1;
    bool settled_ = false, stale_ = false;
    double energy_of_others_ = 0.0; ///< of the cells without a free node
};

} // namespace sinew
