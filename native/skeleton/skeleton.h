// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <array>
#include <limits>
#include <vector>

namespace sinew {

/// How a bone may turn against its parent, measured from rest.
struct Joint
{
    enum class Kind {
        ball,  ///< by a rotation vector (axis times angle) in the bone's own axes, of at most `most`
        angles ///< by three angles about the bone's own axes, each within its bounds
    } kind = Kind::ball;
    double most = std::numeric_limits<double>::infinity(); ///< radians; 0 locks the joint
    /// Radians. Equal bounds lock an axis, and lower bounds above upper ones are refused.
    Vector3 lower = Vector3::Constant(-std::numeric_limits<double>::infinity());
    Vector3 upper = Vector3::Constant(std::numeric_limits<double>::infinity());
    /// The axes of the angles, the first one turned about first: R = R(order[2]) R(order[1]) R(order[0]).
    std::array<int, 3> order{0, 1, 2};
    double stiffness = 1.0; ///< > 0, relative: how firmly the joint stays as it is

    bool operator==(const Joint&) const = default;
};

/// Where the joints are.
struct Posture
{
    /// (bones, 3) of each bone against its parent: rotation vectors for balls, the angles about x, y and z
    /// for the others; zero at rest.
    Points turns;
    Points moves; ///< (bones, 3) how far bones without a parent have moved; zero elsewhere
};

/// Bones of fixed lengths, each turning about its head. A bone that has a parent stays where it is on it; the
/// heads need not lie on the parents' tails.
class Skeleton
{
public:
    /// \param heads, tails  (bones, 3) at rest.
    /// \param parents       (bones) earlier bones, or -1.
    /// \param axes          (bones) rotations whose columns are the bones' own axes at rest; empty for axes
    ///   of which y runs along the bone, turned there from the y axis by the shortest way.
    /// \param joints        (bones) or empty, for joints without limits.
    /// \throw InvalidConstraint  there is no bone; the numbers of rows differ; a number is not finite; a
    ///   bone has no length; a parent is no earlier bone; axes are no rotation.
    /// \throw InvalidOption      limits that no angle meets, or a stiffness that is not positive.
    Skeleton(Points heads, Points tails, std::vector<int> parents, std::vector<Matrix3> axes = {},
             std::vector<Joint> joints = {});

    int bone_count() const { return static_cast<int>(parents_.size()); }
    Vector3 head(int bone) const { return heads_.row(bone).transpose(); }
    Vector3 tail(int bone) const { return tails_.row(bone).transpose(); }
    int parent(int bone) const { return parents_[bone]; }
    const Matrix3& axes(int bone) const { return axes_[bone]; }
    const Joint& joint(int bone) const { return joints_[bone]; }
    double size() const { return size_; } ///< the diagonal of the box around all bones

    Posture rest() const;
    /// (bones) rigid maps from rest.
    /// \throw InvalidConstraint  the posture has another number of bones, or is not finite.
    Poses poses(const Posture& posture) const;
    /// The posture that gives these rotations, whether it is within the limits or not. Of the angles that
    /// give one rotation, those whose middle one is within a right angle.
    /// \param rotations  (bones) of each bone against its parent, in the bone's own axes.
    Posture posture(const std::vector<Matrix3>& rotations) const;
    /// (bones) the rotation of each joint, in the bone's own axes.
    std::vector<Matrix3> rotations(const Posture& posture) const;

    void check(const Posture& posture) const;

private:
    Points heads_, tails_;
    std::vector<int> parents_;
    std::vector<Matrix3> axes_;
    std::vector<Joint> joints_;
    double size_;
};

/// The rotation of a rotation vector, and one of the vectors of a rotation, of length at most pi.
Matrix3 rotation_of(const Vector3& vector);
Vector3 vector_of(const Matrix3& rotation);
/// The rotation of three angles about x, y and z, which come in the order of the joint.
Matrix3 rotation_of(const Joint& joint, const Vector3& angles);

} // namespace sinew
