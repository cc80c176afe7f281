// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/skeleton/skeleton.h"

#include "native/core/dense.h"
#include "native/core/errors.h"
#include "native/core/finite.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace sinew {

namespace {

/// Rotations that come from elsewhere may be in single precision.
constexpr double not_a_rotation = 1e-4;

std::string named(int bone) { return "bone " + std::to_string(bone); }

void require_rows(Eigen::Index count, std::size_t bones, const char* name)
{
    if (count != static_cast<Eigen::Index>(bones))
        throw InvalidConstraint(std::string(name) + ": " + std::to_string(count) + " rows for " +
                                std::to_string(bones) + " bones");
}

void check(const Joint& joint, int bone)
{
    if (!(joint.most >= 0))
        throw InvalidOption(named(bone) + ": the largest turn of its joint is not a number >= 0");
    for (int axis = 0; axis < 3; ++axis)
        if (!(joint.lower[axis] <= joint.upper[axis]))
            throw InvalidOption(named(bone) + ": the lower limit about " + std::string(1, "xyz"[axis]) +
                                " is above the upper one");
    std::array<int, 3> order = joint.order;
    std::ranges::sort(order);
    if (order != std::array<int, 3>{0, 1, 2})
        throw InvalidOption(named(bone) + ": the order of its angles does not name each axis once");
    if (!(joint.stiffness > 0 && std::isfinite(joint.stiffness)))
        throw InvalidOption(named(bone) + ": the stiffness of its joint is not a positive number");
}

/// Its columns turned into unit vectors at right angles.
Matrix3 orthonormal(const Matrix3& axes) { return Eigen::Quaterniond(axes).normalized().toRotationMatrix(); }

/// The angles of a rotation about the axes of a joint, the middle one within a right angle.
Vector3 angles_of(const Joint& joint, const Matrix3& R)
{
    const int i = joint.order[0], j = joint.order[1], k = joint.order[2];
    const double sign = (j - i + 3) % 3 == 1 ? 1.0 : -1.0; // whether (i, j, k) is turned as (x, y, z)
    Vector3 angles;
    const double cosine = std::hypot(R(i, i), R(j, i));
    angles[j] = std::atan2(-sign * R(k, i), cosine);
    if (cosine > 1e-12) {
        angles[i] = std::atan2(sign * R(k, j), R(k, k));
        angles[k] = std::atan2(sign * R(j, i), R(i, i));
    } else { // the first and the last axis are one
        angles[i] = std::atan2(-sign * R(j, k), R(j, j));
        angles[k] = 0.0;
    }
    return angles;
}

} // namespace

Matrix3 rotation_of(const Vector3& vector)
{
    const double angle = vector.norm();
    return angle > 0 ? Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix() : Matrix3::Identity();
}

Vector3 vector_of(const Matrix3& rotation)
{
    const Eigen::Quaterniond q(rotation);
    const double sine = q.vec().norm();
    if (sine == 0)
        return Vector3::Zero();
    const double half = q.w() < 0 ? std::atan2(-sine, -q.w()) : std::atan2(sine, q.w());
    return 2 * half / sine * q.vec();
}

Matrix3 rotation_of(const Joint& joint, const Vector3& angles)
{
    Matrix3 R = Matrix3::Identity();
    for (int axis : joint.order)
        R = Eigen::AngleAxisd(angles[axis], Vector3::Unit(axis)).toRotationMatrix() * R;
    return R;
}

Skeleton::Skeleton(Points heads, Points tails, std::vector<int> parents, std::vector<Matrix3> axes,
                   std::vector<Joint> joints)
    : heads_(std::move(heads)), tails_(std::move(tails)), parents_(std::move(parents)),
      axes_(std::move(axes)), joints_(std::move(joints))
{
    if (parents_.empty())
        throw InvalidConstraint("the skeleton has no bones");
    require_rows(heads_.rows(), parents_.size(), "heads");
    require_rows(tails_.rows(), parents_.size(), "tails");
    if (!all_finite(heads_) || !all_finite(tails_))
        throw InvalidConstraint("the ends of a bone are not finite");
    if (joints_.empty())
        joints_.resize(parents_.size());
    require_rows(static_cast<Eigen::Index>(joints_.size()), parents_.size(), "joints");
    const bool own_axes = axes_.empty();
    if (own_axes)
        axes_.resize(parents_.size());
    require_rows(static_cast<Eigen::Index>(axes_.size()), parents_.size(), "axes");
    for (int b = 0; b < bone_count(); ++b) {
        if (parents_[b] < -1 || parents_[b] >= b)
            throw InvalidConstraint(named(b) + ": its parent " + std::to_string(parents_[b]) +
                                    " is no earlier bone");
        const Vector3 along = tail(b) - head(b);
        if (!(along.norm() > 0))
            throw InvalidConstraint(named(b) + " has no length");
        if (own_axes)
            axes_[b] = smallest_turn(Vector3::UnitY(), along).toRotationMatrix();
        else if (!(axes_[b].transpose() * axes_[b]).isIdentity(not_a_rotation) ||
                 !(axes_[b].determinant() > 0))
            throw InvalidConstraint(named(b) + ": its axes are no rotation");
        axes_[b] = orthonormal(axes_[b]);
        sinew::check(joints_[b], b);
    }
    const Eigen::RowVector3d least = heads_.colwise().minCoeff().cwiseMin(tails_.colwise().minCoeff()),
                             most = heads_.colwise().maxCoeff().cwiseMax(tails_.colwise().maxCoeff());
    size_ = (most - least).norm();
}

Posture Skeleton::rest() const { return {Points::Zero(bone_count(), 3), Points::Zero(bone_count(), 3)}; }

void Skeleton::check(const Posture& posture) const
{
    require_rows(posture.turns.rows(), parents_.size(), "turns");
    require_rows(posture.moves.rows(), parents_.size(), "moves");
    if (!all_finite(posture.turns) || !all_finite(posture.moves))
        throw InvalidConstraint("a turn or a move of a bone is not finite");
}

std::vector<Matrix3> Skeleton::rotations(const Posture& posture) const
{
    check(posture);
    std::vector<Matrix3> all(parents_.size());
    for (int b = 0; b < bone_count(); ++b) {
        const Vector3 turn = posture.turns.row(b).transpose();
        all[b] = joints_[b].kind == Joint::Kind::ball ? rotation_of(turn) : rotation_of(joints_[b], turn);
    }
    return all;
}

Poses Skeleton::poses(const Posture& posture) const
{
    const std::vector<Matrix3> turns = rotations(posture);
    Poses poses(parents_.size());
    for (int b = 0; b < bone_count(); ++b) {
        const int parent = parents_[b];
        const Matrix3 own = axes_[b] * turns[b] * axes_[b].transpose();
        const Matrix3 turn = parent < 0 ? own : Matrix3(poses[parent].leftCols<3>() * own);
        const Vector3 place =
            parent < 0 ? Vector3(head(b) + posture.moves.row(b).transpose()) : apply(poses[parent], head(b));
        // A product of rotations stays one to rounding only if it is made one again, bone by bone.
        poses[b].leftCols<3>() = orthonormal(turn);
        poses[b].col(3) = place - poses[b].leftCols<3>() * head(b);
    }
    return poses;
}

Posture Skeleton::posture(const std::vector<Matrix3>& rotations) const
{
    require_rows(static_cast<Eigen::Index>(rotations.size()), parents_.size(), "rotations");
    Posture posture = rest();
    for (int b = 0; b < bone_count(); ++b) {
        if (!all_finite(rotations[b]) ||
            !(rotations[b].transpose() * rotations[b]).isIdentity(not_a_rotation) ||
            !(rotations[b].determinant() > 0))
            throw InvalidConstraint(named(b) + ": the matrix of its joint is no rotation");
        const Matrix3 R = orthonormal(rotations[b]);
        posture.turns.row(b) =
            (joints_[b].kind == Joint::Kind::ball ? vector_of(R) : angles_of(joints_[b], R)).transpose();
    }
    return posture;
}

} // namespace sinew
