// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/skeleton/pose_solver.h"
#include "native/skeleton/support.h"
#include "native/solvers/optimization/gauss_newton.h"

#include <optional>
#include <vector>

namespace sinew {

/// The sum of squares of solve_pose(). Its unknowns are the turns of joints that may turn, and the moves of
/// roots that may move, as shares of the size of the skeleton. A ball joint without a limit counts from where
/// it is in `base`, so that rotation vectors stay small, and about the axes of its hinge; all others count
/// from rest, about the bone's own axes.
class PoseProblem final : public LeastSquares
{
public:
    /// Both have to outlive the problem.
    PoseProblem(const Skeleton& skeleton, const PoseRequest& request, const PoseSolverOptions& options,
                Posture base);

    /// Lets the turns of joints count by this weight instead of the `rest` of the options.
    void set_rest(double rest) { rest_ = rest; }
    int size() const { return static_cast<int>(unknowns_.size()); }
    const VariableLimits& limits() const { return limits_; }
    /// The unknowns of the base posture, moved into the limits.
    VectorX base() const { return base_x_; }
    /// The start of a solve.
    VectorX start() const;
    /// Lets joints that have turned by more than half a turn get there the other way.
    /// \return whether there were any.
    bool unwind(VectorX& x) const;
    /// The posture of the unknowns.
    Posture posture(const VectorX& x) const;
    const std::vector<double>& gaps() const { return gaps_; } ///< of the x that was evaluated last
    /// Likewise; zero without balance.
    const Vector3& centre() const { return centre_; }

    void evaluate(const VectorX& x, Values& values) override;
    void linearize(const VectorX& multipliers, Slopes& slopes) override;

private:
    struct Unknown
    {
        int bone, axis;
        bool moves;
    };
    /// What acts on the bones from a joint on: the sums of f and of f p^T over points p with forces f.
    struct Load
    {
        Vector3 force = Vector3::Zero();
        Matrix3 moment = Matrix3::Zero();
    };

    bool counts_from_base(int bone) const;
    void set_up_balance();
    void place(const VectorX& x);
    Matrix3 joint_axes(int bone, const Vector3& turn) const;
    Vector3 column(const Unknown& unknown, const Vector3& axis, const Vector3& point) const;
    bool is_inner(int v, int u) const;

    const Skeleton& skeleton_;
    const PoseRequest& request_;
    const PoseSolverOptions& options_;
    Posture base_;
    std::vector<Matrix3> base_turns_;
    std::vector<Matrix3> hinges_; ///< (bones) the axes of the turns, in the bone's own ones
    std::vector<Unknown> unknowns_;
    std::vector<int> first_; ///< (bones + 1) unknowns of each bone
    VariableLimits limits_;
    VectorX base_x_, stiffness_; ///< the stiffness beside `rest_`
    double rest_;
    std::optional<Support> support_;
    std::vector<double> masses_; ///< their sum is 1
    Points centres_;

    // At the x that was evaluated last:
    VectorX x_;
    Points turns_; ///< by the unknowns: of balls that count from `base` from there on, about axes_
    std::vector<Matrix3> before_; ///< the world rotation of each joint's axes before it turns
    Poses poses_;
    std::vector<double> gaps_;
    Vector3 centre_ = Vector3::Zero();
};

} // namespace sinew
