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

/// The eigenvectors of the spread (sum of arm arm^T) of points, as the columns of a rotation: longest, second
/// and normal. Directions along which the points are spread equally, up to a fiftieth of the variance, leave
/// them open. Then the normal is as near as possible to z, and the first axis to `hint`, or to x if no more
/// of the hint lies in the plane than `least_hint`.
Matrix3 principal_axes(const Matrix3& spread, const Vector3& hint = Vector3::Zero(), double least_hint = 0.0);

/// The principal_axes() about the mean. A hint counts if more of it lies in the plane than a twentieth of the
/// longest side of the box around the points.
/// \param vertices  rows of `points`, one or more.
PrincipalFrame principal_frame(const Points& points, const std::vector<int>& vertices,
                               const Vector3& hint = Vector3::Zero());

} // namespace sinew
