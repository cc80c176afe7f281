// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/handles/handle_groups.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"

#include <Eigen/Geometry>

#include <span>
#include <vector>

namespace sinew {

/// The vertices of the triangles that each handle touches, with repetitions: (k) lists.
std::vector<std::vector<int>> handle_patches(const SurfaceMesh& mesh, const Regions& regions);

/// The linear maps by which the handles move the shape that enters, (k). For a handle that aims from rest,
/// its patch has been turned already on the way from rest to the shape that enters, by the rotation that fits
/// best; its map is the pose without that rotation.
/// \param patches  of handle_patches().
std::vector<Matrix3> linear_maps(const Targets& targets, const std::vector<std::vector<int>>& patches);

/// A = R S with R a rotation and S symmetric. Where A reflects, so does S.
struct Polar
{
    explicit Polar(const Matrix3& A);

    Matrix3 R, S;
};

/// A rotation in the middle of some others: the mean of their quaternions, a quaternion and its negative
/// being one rotation. Where rotations oppose each other by half a turn there is no mean, and it is the first
/// of them.
Eigen::Quaterniond mean_rotation(std::span<const Eigen::Quaterniond> rotations);

/// The rotation vector (axis times angle, at most pi) that leads from one rotation to another, in the frame
/// of the first. Of the two ways of half a turn, it goes the one whose first larger component is positive, so
/// that rounding does not choose.
Vector3 rotation_between(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to);

/// Linear maps of handles, as numbers whose means are maps in between:
///
///     A_h = R_h S_h,    T = R exp(sum_h s_h log(R^T R_h)) (sum_h s_h S_h),
///
/// with R the mean of the rotations R_h of a part. For two handles, this is Eq. 16 of the tutorial,
/// corrected: slerp(I, R, s) (s S + (1 - s) I) where one of them rests. Rotations of less than half a turn
/// against each other are reproduced; beyond, the shorter way is taken.
class MapBlend
{
public:
    static constexpr int numbers = 9;

    /// \param maps  (k) one per handle.
    MapBlend(const HandleGroups& groups, const std::vector<Matrix3>& maps);

    /// (seats, 9) what HandleFields::blend() takes the means of.
    const RowMatrix& values() const { return values_; }

    /// T at one place of a part.
    class Map
    {
    public:
        /// \param mean  R of the part; \param nine  the mean of values().
        Map(const Matrix3& mean, const double* nine);
        explicit Map(const Matrix3& map) : mean_(Matrix3::Identity()), turn_(0, 0, 0), S_(map) {}

        Vector3 operator()(const Vector3& v) const
        {
            const Vector3 u = S_ * v, across = turn_.cross(u);
            return mean_ * (u + sine_ * across + cosine_ * turn_.cross(across));
        }

    private:
        Matrix3 mean_;
        Vector3 turn_; ///< the rotation vector r
        Matrix3 S_;
        double sine_ = 1.0, cosine_ = 0.5; ///< sin |r| / |r| and (1 - cos |r|) / |r|^2
    };
    /// Where all handles of a part have one map, exactly that one.
    Map at(int group, const double* nine) const
    {
        return alike_[group] ? Map(means_[group]) : Map(means_[group], nine);
    }

private:
    std::vector<char> alike_;    ///< whether all handles of each group have one map
    std::vector<Matrix3> means_; ///< of their rotations; that map itself where it is one
    RowMatrix values_;
};

} // namespace sinew
