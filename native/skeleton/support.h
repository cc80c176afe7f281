// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <vector>

namespace sinew {

/// A convex polygon, seen along `up`: a point is above it where no side is positive.
class Support
{
public:
    /// The convex hull of some points.
    /// \throw InvalidConstraint  fewer than three points, a number that is not finite, or a hull of no area.
    Support(const Points& points, const Vector3& up);

    int side_count() const { return static_cast<int>(normals_.size()); }
    const Vector3& normal(int side) const { return normals_[side]; } ///< a unit vector across `up`, outward
    /// How far a point is outside of a side.
    double outside(int side, const Vector3& point) const
    {
        return normals_[side].dot(point) - offsets_[side];
    }

private:
    std::vector<Vector3> normals_;
    std::vector<double> offsets_;
};

} // namespace sinew
