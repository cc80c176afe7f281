// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/surface/nonlinear/pyramids/cells.h"
#include "native/solvers/optimization/metric_lbfgs.h"

#include <vector>

namespace sinew {

/// The workspace of a PyramidProblem. If it is kept from one solve to the next, it is not allocated again.
struct PyramidBuffers
{
    std::vector<double> points, rotations, forces, sums, energies, sizes;
    Points gradient;
};

/// F of PyramidCells as a function of the moving points: every evaluation fits the rotations to them, so no
/// accepted step of minimize() raises it.
class PyramidProblem final : public MetricProblem
{
public:
    /// The range of s where the cells follow similarities s R.
    static constexpr double least_scale = 0.5, most_scale = 2.0;

    /// \param shape    the shape to be kept; it has to outlive the problem.
    /// \param scaled   whether each cell follows a similarity instead of a rotation.
    /// \param places   (n, 3) by vertices: where the points that do not move are.
    /// \param pulls    (pulls, 3) where the pulls pull.
    PyramidProblem(const PyramidCells& cells, const PyramidShape& shape, bool scaled, const Points& places,
                   const Points& pulls, PyramidBuffers& buffers);

    /// \param R  a rotation, or a similarity; of a cell.
    void set_rotation(int cell, const Matrix3& R);

    /// (moving, 3) the points that minimise F for the present rotations.
    void global_step(Points& x);
    /// Twice the energy of the shape if all points were in one place: its rounding is in proportion to it.
    double scale() const { return scale_; }

    double evaluate(const Points& x, Points& gradient) override;
    void precondition(const Points& gradient, Points& z) const override;
    void keep_state() override {}
    void restore_state() override {}

    /// (n, 3) by vertices, with the moving points at x.
    void place(const Points& x, Points& all);

private:
    void move_to(const Points& x);
    double pass(bool fit, Points& gradient);

    const PyramidCells& cells_;
    const PyramidKernels& kernels_;
    const bool scaled_;
    const Points& pulls_;
    PyramidBuffers& buffers_;
    PyramidView view_;
    double scale_;
};

} // namespace sinew
