// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <vector>

namespace sinew {

/// The plane of least squares through points, with axes along which they are spread most.
struct PrincipalFrame
{
    Vector3 centre = Vector3::Zero(); ///< the mean of the points
    /// Columns: the longest direction, the second one, and the normal of the plane; a rotation.
    Matrix3 axes = Matrix3::Identity();

    /// (3) a point in this frame.
    Vector3 seen(const Vector3& point) const { return axes.transpose() * (point - centre); }
};

/// Directions along which the points are spread equally, up to a fiftieth of the variance, leave the frame
/// open. Then the normal is as near as possible to z, and the first axis to `hint`, or to x if less of the
/// hint lies in the plane than a twentieth of the longest side of the box around the points.
/// \param vertices  rows of `points`, one or more.
PrincipalFrame principal_frame(const Points& points, const std::vector<int>& vertices,
                               const Vector3& hint = Vector3::Zero());

} // namespace sinew
