// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/local_global/rows/row_system.h"
#include "native/solvers/optimization/metric_lbfgs.h"

#include <memory>
#include <vector>

namespace sinew {

/// The workspace of a RowProblem. If it is kept from one solve to the next, it is not allocated again.
struct RotationBuffers
{
    std::vector<double> points;       ///< three numbers per point, in the inner order
    std::vector<double> rotations[3]; ///< nine per group; with pairs, one of them is what keep_state() keeps
    std::vector<double> forces; ///< three per row, or twelve per cell of four points
    std::vector<double> energies; ///< one per chunk
    Points torque, gradient;
};

/// E of a table of rows as a function of the free points, with the rotations as its state: every evaluation
/// fits them to the positions.
///
/// Without pairs, E is a function of the positions, and no accepted step of minimize() raises it. With pairs,
/// an evaluation moves the rotations closer to the best ones; E never rises by that either, once they are
/// near.
class RowProblem final : public MetricProblem
{
public:
    /// \param vectors  those of the shape whose rows are to be kept; they have to outlive the problem.
    /// \param held     (points, 3) where the held points are; rows of free points are not read.
    /// \param pulls    (pulls, 3) where the pulls of the table that act on free points pull them.
    /// \param buffers  the workspace, which may be that of an earlier problem; null for one of its own.
    RowProblem(const RowSystem& cells, const RotationVectors& vectors, const Points& held,
               const Points& pulls = {}, RotationBuffers* buffers = nullptr);

    /// Of a group, by its number in the table. After a rejected step of a table without pairs, it belongs to
    /// the rejected positions.
    Matrix3 rotation(int group) const;
    void set_rotation(int group, const Matrix3& R);

    /// (free, 3) the positions that minimise E for the present rotations: a linear solve, and further ones
    /// for the residual of the one before.
    void global_step(Points& x, int solves = 2);

    double evaluate(const Points& x, Points& gradient) override;
    void precondition(const Points& gradient, Points& z) const override;
    void keep_state() override { kept_ = cells_.has_pairs() ? current_ : -1; }
    void restore_state() override
    {
        if (cells_.has_pairs())
            current_ = kept_;
    }

    /// (points, 3) the positions of all points by their numbers in the table, with the free ones at x.
    void place(const Points& x, Points& all);

private:
    using Rotations = std::vector<double>;

    void move_to(const Points& x);
    double pass(bool fit);
    double own_rows(const RowSystem::Chunk& chunk, bool fit);
    void find_residuals();
    void settle_pairs();
    double with_pulls(double energy, Points& gradient) const;
    /// A set of rotations that is neither kept nor the present one.
    Rotations& spare();

    const RowSystem& cells_;
    const RowKernels& kernels_;
    const Points& pulls_;
    std::unique_ptr<RotationBuffers> own_buffers_;
    RotationBuffers& buffers_;
    RowView view_;
    int current_ = 0, kept_ = -1;
    bool fixed_settled_ = false;
    double fixed_energy_ = 0.0; ///< of groups that touch no free point
};

} // namespace sinew
