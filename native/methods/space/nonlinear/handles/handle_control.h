// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/methods/space/handle_points/handle_points.h"

#include <vector>

namespace sinew {

/// How a handle moves: y -> y + turn y + move.
struct HeldMotion
{
    Matrix3 turn; ///< the linear part of its pose, less the identity
    Vector3 move;

    Vector3 operator()(const Vector3& y) const { return turn * y + move; } ///< the displacement
};

/// What handles do with the points that they hold: regions of the shape, or the place of a control that has
/// no region.
class HandleControl
{
public:
    /// \param centre, unit  of the coordinates of the motions: y = (x - centre) / unit.
    HandleControl(HandlePoints held, const Vector3& centre, double unit);

    const HandlePoints& held() const { return held_; }
    int count() const { return held_.handle_count(); }

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
        int rank; ///< 0 for a point, 1 on a line, 2 on a plane, 3
        Vector3 middle;
        Matrix3 inverse; ///< of their second moment; only where the rank is 3
    };
    Extent extent(int handle) const;
    HeldMotion fit(int handle, PointsView posed) const;
    void check(const std::vector<HeldMotion>& motions) const;

    /// The rows of a handle.
    template <class Rows>
    auto own(const Rows& rows, int handle) const
    {
        return rows.middleRows(held_.begin(handle), held_.count(handle));
    }

    HandlePoints held_;
    Vector3 centre_;
    double unit_;
    Points places_; ///< of the points, in the coordinates of motions
    std::vector<Extent> extents_;
};

} // namespace sinew
