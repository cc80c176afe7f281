// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <array>
#include <vector>

namespace sinew {

/// Points that move with handles: regions of the shape, or the place of a control that has no region.
struct HandlePoints
{
    Points points;               ///< (c, 3) at rest, handle after handle
    std::vector<int> counts;     ///< (k) how many each handle holds
    std::vector<double> weights; ///< (c) in (0, 1], how strongly each is held; empty where all are 1

    bool operator==(const HandlePoints& other) const
    {
        return counts == other.counts && weights == other.weights && points.rows() == other.points.rows() &&
               points == other.points;
    }
};

/// How a handle moves: y -> y + turn y + move.
struct HandleMotion
{
    Matrix3 turn; ///< the linear part of its pose, less the identity
    Vector3 move;

    Vector3 operator()(const Vector3& y) const { return turn * y + move; } ///< the displacement
};

/// Handles as points of a control: four for each, a frame of the handle at rest, which its pose takes along.
/// So any affine map of the control is one of all handles.
class HandleFrames
{
public:
    /// \param centre, unit  of the coordinates of the motions: y = (x - centre) / unit.
    /// \throw InvalidConstraint  there is no handle, a handle holds no point, the counts do not add up, a
    ///   point is not finite, or there is another number of weights than of points.
    /// \throw InvalidOption      a weight is not in (0, 1].
    HandleFrames(HandlePoints held, const Vector3& centre, double unit);

    int count() const { return static_cast<int>(held_.counts.size()); }
    const HandlePoints& held() const { return held_; }
    int handle_of(int point) const { return handle_of_[point]; }
    double weight(int point) const { return held_.weights.empty() ? 1.0 : held_.weights[point]; }

    /// (4 k, 3) the control at rest.
    const Points& rest() const { return rest_; }
    /// (4 k, 3) the control that poses make. \throw InvalidConstraint  another number of poses.
    Points posed(const Poses& poses) const;
    /// (k) exactly zero for a control at rest.
    /// \throw InvalidConstraint  another number of points, one is not finite, or two handles take one point
    ///   that both hold fully to two places.
    std::vector<HandleMotion> motions(PointsView control) const;

private:
    HandlePoints held_;
    Vector3 centre_;
    double unit_;
    std::vector<int> handle_of_;
    Points rest_;
    std::vector<std::array<int, 2>> coincident_; ///< pairs of points at one place that two handles hold
};

} // namespace sinew
