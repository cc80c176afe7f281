// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <array>
#include <vector>

namespace sinew {

/// Points that move with handles: regions of the shape, or the place of a control that has no region.
struct HeldPoints
{
    Points points;               ///< (c, 3) at rest, handle after handle
    std::vector<int> counts;     ///< (k) how many each handle holds
    std::vector<double> weights; ///< (c) in (0, 1], how strongly each is held; empty where all are 1

    bool operator==(const HeldPoints& other) const
    {
        return counts == other.counts && weights == other.weights && points.rows() == other.points.rows() &&
               points == other.points;
    }
};

/// How a handle moves: y -> y + turn y + move.
struct HeldMotion
{
    Matrix3 turn; ///< the linear part of its pose, less the identity
    Vector3 move;

    Vector3 operator()(const Vector3& y) const { return turn * y + move; } ///< the displacement
};

/// What handles do with the points that they hold.
class HandleControl
{
public:
    /// \param centre, unit  of the coordinates of the motions: y = (x - centre) / unit.
    /// \throw InvalidConstraint  there is no handle, a handle holds no point, the counts do not add up, a
    ///   point is not finite, or there is another number of weights than of points.
    /// \throw InvalidOption      a weight is not in (0, 1].
    HandleControl(HeldPoints held, const Vector3& centre, double unit);

    int count() const { return static_cast<int>(held_.counts.size()); }
    const HeldPoints& held() const { return held_; }
    int handle_of(int point) const { return handle_of_[point]; }
    double weight(int point) const { return held_.weights.empty() ? 1.0 : held_.weights[point]; }

    /// (k) exactly zero for the identity.
    /// \throw InvalidConstraint  another number of poses, one is not finite, or two handles take one point
    ///   that both hold fully to two places.
    std::vector<HeldMotion> motions(const Poses& poses) const;
    /// (k) those that fit posed points (c, 3) best: affine maps. Points on one plane or line leave these
    /// open, so that there they are rigid motions, with the least turn about a line; a single point moves
    /// only. Exactly zero where no point of the handle moves.
    /// \throw as motions() of poses
    std::vector<HeldMotion> motions(PointsView posed) const;

private:
    /// The points of a handle, in the coordinates of motions.
    struct Extent
    {
        int first, rank;  ///< 0 for a point, 1 on a line, 2 on a plane, 3
        Vector3 middle;
        Matrix3 inverse; ///< of their second moment; only where the rank is 3
    };
    Extent extent(int first, int count) const;
    HeldMotion fit(const Extent& extent, int count, PointsView posed) const;
    void check(const std::vector<HeldMotion>& motions) const;

    HeldPoints held_;
    Vector3 centre_;
    double unit_;
    std::vector<int> handle_of_;
    Points places_; ///< of the points, in the coordinates of motions
    std::vector<Extent> extents_;
    std::vector<std::array<int, 2>> coincident_; ///< pairs of points at one place that two handles hold
};

} // namespace sinew
