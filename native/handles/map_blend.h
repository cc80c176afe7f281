// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/handles/handle_groups.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"

#include <Eigen/Geometry>

#include <array>
#include <cmath>
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

/// Whether one of two rotations is the other one turned by half a turn, up to rounding.
bool opposed(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

/// The rotation vector (axis times angle, at most pi) that leads from one rotation to another, in the frame
/// of the first. Of the two ways of half a turn, it goes the one whose first larger component is positive, so
/// that rounding does not choose.
Vector3 rotation_between(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to);

/// sin(a) / a and cos(a), from the square of a.
struct SineAndCosine
{
    /// The factors of 1, a^2, a^4 ... in cos(a), and in sin(a) / a where `more` is 1. Up to a right angle,
    /// the next ones are below rounding.
    static constexpr std::array<double, 12> series(int more)
    {
        std::array<double, 12> factors{1.0};
        for (int k = 1; k < 12; ++k)
            factors[k] = -factors[k - 1] / ((2 * k - 1 + more) * (2 * k + more));
        return factors;
    }

    explicit SineAndCosine(double square)
    {
        constexpr std::array<double, 12> sines = series(1), cosines = series(0);
        if (square > 2.5) {
            const double angle = std::sqrt(square);
            sine = std::sin(angle) / angle;
            cosine = std::cos(angle);
            return;
        }
        for (int k = 11; k >= 0; --k) {
            sine = sine * square + sines[k];
            cosine = cosine * square + cosines[k];
        }
    }

    double sine = 0.0, cosine = 0.0;
};

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

    /// (part handles, 9) what HandleFields::blend() takes the means of.
    const RowMatrix& values() const { return values_; }
    /// Whether all handles of a part have one map, and R of a part where they have not.
    bool alike(int group) const { return alike_[group]; }
    const Matrix3& mean(int group) const { return means_[group]; }
    /// How many vertices are in parts where a rule chose the way of half a turn.
    int half_turns(const HandleGroups& groups) const;

    /// T at one place of a part.
    class Map
    {
    public:
        /// \param mean  R of the part; \param nine  the mean of values().
        Map(const Matrix3& mean, const double* nine) : mean_(mean), turn_(nine[0], nine[1], nine[2])
        {
            S_ << nine[3], nine[4], nine[5], nine[4], nine[6], nine[7], nine[5], nine[7], nine[8];
            const SineAndCosine half(0.25 * turn_.squaredNorm());
            sine_ = half.sine * half.cosine;
            cosine_ = 0.5 * half.sine * half.sine;
        }
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
    std::vector<char> alike_; ///< whether all handles of each group have one map
    std::vector<char> decided_; ///< whether a rule chose the way of half a turn in each group
    std::vector<Matrix3> means_; ///< of their rotations; that map itself where it is one
    RowMatrix values_;
};

} // namespace sinew
