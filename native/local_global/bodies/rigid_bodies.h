// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/local_global/arap/arap_kernels.h"
#include "native/local_global/arap/arap_system.h"
#include "native/local_global/bodies/body_kernels.h"
#include "native/solvers/single_factor.h"

#include <array>
#include <functional>
#include <vector>

namespace sinew {

/// What a joint has from the base shape.
struct JointShape
{
    Vector3 lever[2]; ///< p and q: from the centre of each body to the middle of the joint
    Matrix3 form;     ///< B / w, symmetric and positive semi-definite
};

/// An elastic joint of two bodies.
struct BodyJoint
{
    int body[2];
    double weight; ///< w > 0
};

/// Rigid bodies that elastic joints hold together. Body i has its centre at t_i and the rotation R_i:
///
///     E(t, R) = 1/2 sum w |(t_i + R_i p) - (t_j + R_j q)|^2 + 1/2 sum tr((R_i - R_j) B (R_i - R_j)^T)
///
/// over all joints, and soft pulls of centres. Several rows |(R_i - R_j) u|^2 of one joint are one form
/// B = sum u u^T. This is the energy of a table of RowTable with pairs, in a layout that is read less
/// often: the bodies are the nodes of a ArapSystem, whose edges have the weights of the joints, so that
/// the Hessian in t is the Laplacian of the graph, whose factor is used.
class RigidBodies
{
public:
    /// Joints of two bodies that do not move are left out.
    /// \param graph    whose nodes are the bodies; it is not kept.
    /// \param joints   in the numbers of the graph's nodes; a, b and c, d may be the same two bodies.
    /// \param rest     gives the shape of each joint at rest.
    /// \param sweeps   how often an evaluation moves and fits the rotations.
    /// \throw FactorizationFailed
    using Shapes = std::function<JointShape(int joint)>;
    RigidBodies(const ArapSystem& graph, std::vector<BodyJoint> joints, const Shapes& rest, int sweeps);

    int size() const { return size_; }
    int free_count() const { return free_; }
    int sweeps() const { return sweeps_; }
    const std::vector<BodyJoint>& joints() const { return joints_; }
    /// The numbers of all joints for BodyView::joints.
    void lay_out(const Shapes& shapes, std::vector<double>& numbers) const;
    const std::vector<double>& rest_numbers() const { return rest_; }
    /// The factor of the Hessian of E in the rotations at rest, M, on the bodies that move.
    const SingleFactor& rotation_factor() const { return rotation_factor_; }
    /// 1/2 sum w |p|^2 + tr B. The rounding error of the energy is proportional to it.
    double scale(const std::vector<double>& numbers) const;
    /// The view, without numbers and points.
    BodyView view() const { return {first_.data(), others_.data(), nullptr, free_, nullptr}; }

private:
    void factorize(const Shapes& rest, const std::vector<int>& order);

    int size_, free_, sweeps_;
    std::vector<BodyJoint> joints_;
    std::vector<int> first_, others_;
    std::vector<std::array<int, 2>> places_; ///< of each joint among those of its two bodies, or -1
    std::vector<double> rest_;
    SingleFactor rotation_factor_;
};

} // namespace sinew
