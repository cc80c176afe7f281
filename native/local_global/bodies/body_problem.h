// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/local_global/bodies/rigid_bodies.h"
#include "native/solvers/optimization/metric_lbfgs.h"

#include <memory>
#include <vector>

namespace sinew {

/// The workspace of a BodyProblem. If it is kept from one solve to the next, it is not allocated again.
struct BodyBuffers
{
    std::vector<double> points;       ///< three numbers per body
    std::vector<double> rotations[3]; ///< nine per body; one of them is what keep_state() keeps
    std::vector<double> energies;     ///< one per chunk
    Points torque, gradient;
};

/// E of RigidBodies as a function of the centres of the bodies that move, with the rotations as its state.
/// Every evaluation moves the rotations closer to the best ones: first all of them together by a solve with
/// M, then each by a fit to its neighbours.
class BodyProblem final : public MetricProblem
{
public:
    /// \param graph    that of the bodies.
    /// \param numbers  the joints for the shape that is to be kept; they have to outlive the problem.
    /// \param centres  (bodies, 3) where the held ones are, and where the others begin.
    /// \param pulls    (pulls, 3) where the pulls of the graph pull their bodies.
    /// \param buffers  the workspace, which may be that of an earlier problem; null for one of its own.
    BodyProblem(const ArapSystem& graph, const RigidBodies& bodies, const std::vector<double>& numbers,
                const Points& centres, const Points& pulls, BodyBuffers* buffers = nullptr);

    Matrix3 rotation(int body) const;
    /// Sets the rotation of a body, for all time if the body is held. That of a held one may be any matrix:
    /// then it deforms as this matrix says.
    void set_rotation(int body, const Matrix3& R);

    /// (free, 3) the centres that minimise E for the present rotations: a linear solve, and a second one for
    /// the residual of the first.
    void centres_for_rotations(Points& x);
    /// Where all bodies are, the free ones at x.
    PointsView place(const Points& x);

    double evaluate(const Points& x, Points& gradient) override;
    void precondition(const Points& gradient, Points& z) const override
    {
        graph_.position_factor().solve(gradient, z);
    }
    void keep_state() override { kept_ = current_; }
    void restore_state() override { current_ = kept_; }

private:
    void move_to(const Points& x);
    void settle();
    double energy_and_gradient(Points& gradient) const;
    /// A set of rotations that is neither kept nor the present one.
    int spare() const;
    template <class Body>
    void each_chunk(Body&& body) const;

    const ArapSystem& graph_;
    const RigidBodies& bodies_;
    const BodyKernels& kernels_;
    const Points& pulls_;
    std::unique_ptr<BodyBuffers> own_buffers_;
    BodyBuffers& buffers_;
    BodyView view_;
    int current_ = 0, kept_ = -1;
};

} // namespace sinew
