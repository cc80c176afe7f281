// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/skeleton/skeleton.h"

#include <optional>
#include <vector>

namespace sinew {

/// A point that a bone carries, and where it is wanted.
struct BoneTarget
{
    int bone;
    Vector3 point; ///< at rest
    Vector3 goal;
    double weight = 1.0; ///< > 0, relative
};

/// Keeps the centre of mass above a support: the convex hull of some points, seen along `up`.
struct Balance
{
    Points support; ///< (m, 3) for example of the corners of the soles
    Vector3 up = Vector3::UnitZ();
    std::vector<double> masses{}; ///< (bones) >= 0; empty for the lengths of the bones
    Points centres{}; ///< (bones, 3) at rest; without rows, the middles of the bones
};

struct PoseSolverOptions
{
    /// The weight of what joints turn (radians, squared), beside that of targets (their distances as shares
    /// of the size of the skeleton, squared): small, so that targets are met nearly exactly.
    double rest = 1e-4;
    /// By how much each joint is bent at the start, in radians. A straight chain does not bend by itself.
    double pole = 1e-3;
    int max_iterations = 200;
    double tolerance = 1e-6; ///< stop when a step lowers F by at most this share of it
    /// How much more it counts that a joint turns aside of its hinge than about it.
    double swing = 1.0;
};

/// What a pose is solved for.
struct PoseRequest
{
    std::vector<BoneTarget> targets;
    /// The posture that joints stay close to; without one, rest. Joints outside of their limits are moved
    /// into them.
    std::optional<Posture> base{};
    std::vector<bool> moving_roots{}; ///< (bones) whether a bone without a parent may move, or empty for none
    std::vector<bool> locked{}; ///< (bones) whose joints stay as in `base`, or empty for none
    std::optional<Balance> balance{};
};

struct PoseReport
{
    int iterations = 0;
    int rejected = 0;
    double energy = 0.0; ///< F
    bool converged = false;
    std::vector<double> gaps; ///< (targets) how far from their goals the points are
    Vector3 centre = Vector3::Zero(); ///< of mass, if the request asks for balance
    double overhang = 0.0; ///< how far it is outside of the support
};

/// Turns the joints of a skeleton so that points on its bones come to their goals.
///
/// X. Shi, K. Zhou, Y. Tong, M. Desbrun, H. Bao, B. Guo. "Mesh Puppetry: Cascading Optimization of Mesh
/// Deformation with Inverse Kinematics." SIGGRAPH 2007.
///
/// Minimises
///
///     F = 1/2 sum_t w_t |p_t - g_t|^2 / size^2
///         + rest / 2 sum_b k_b (|theta_b - base_b|^2 + swing |S_b (theta_b - base_b)|^2)
///
/// over the turns theta_b of the joints and the moves of free roots, by damped Gauss-Newton steps with the
/// curvature of the chains (solvers/optimization/gauss_newton.h). Lengths are exact, since only joints turn.
/// Limits are never exceeded, and balance is an inequality that the steps satisfy: targets come as near as
/// these two allow. S_b = I - h_b h_b^T leaves what is at right angles to the hinge h_b of a joint, so that
/// knees and elbows keep to the plane in which they are bent at rest; it is 0 for joints without a hinge
/// (hinges.h). A root that moves freely has no rest term, so that goals which have all moved rigidly are met
/// exactly.
///
/// Departs from the paper: the paper solves for the skeleton and the skin in turns; here the skeleton is
/// solved first, and the skin follows. Joints with limits turn by angles about the bones' own axes or by a
/// bounded rotation vector instead of the paper's penalties.
///
/// The start depends on the request alone: the base posture, with free roots moved as the goals have moved on
/// average, and each joint bent by `pole`: further about its hinge, or else about the first axis that is
/// free. Bones also lean a little away from the middle of the skeleton, so that both sides of a symmetric one
/// start alike. F is then minimised with `rest` at .01, .003 and .001, roughly, and at last as asked for.
/// While joints are stiff they hardly have several postures, and the way from there to soft joints changes
/// little where goals do; steps that begin with soft joints crawl along the ring on which an elbow may be,
/// and end anywhere on it. A joint that ends up turned by more than half a turn gets there the other way, and
/// the steps go on. If all targets are met there without any of that, the base posture is the answer, to the
/// bit.
///
/// Cost per iteration: n^2 (targets + n / 3) operations for n unknowns, at most three per bone. Safe from
/// several threads.
///
/// \throw InvalidConstraint  a target, mass, centre or point of the support is not finite or has a wrong
///   index, a weight is not positive, masses are negative or all zero, or the support has no area.
PoseReport solve_pose(const Skeleton& skeleton, const PoseRequest& request, Posture& posture,
                      const PoseSolverOptions& options = {});

} // namespace sinew
