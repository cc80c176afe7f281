// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"

#include <vector>

namespace sinew {

/// The mean of the vertices of all handles in a shape.
Vector3 centre_of_handles(const Regions& regions, const PointsView& shape);

/// Poses on the way from rest: each is a screw at a constant speed (by the shorter way; of two ways of half a
/// turn, by that of rotation_between()) after a scale that grows at a constant speed. So handles with one
/// pose stay together all the way, and a handle that rests does not move.
class PathOfPoses
{
public:
    /// \param centre  of the scales.
    PathOfPoses(const Poses& poses, const Vector3& centre);

    /// \param share  of the way, in [0, 1].
    Poses at(double share) const;

private:
    struct Way
    {
        Vector3 axis; ///< unit
        double angle;
        Matrix3 scale;
        Vector3 along, across; ///< the move of the centre, as seen from the axis
    };
    std::vector<Way> ways_;
    Vector3 centre_;
};

/// The same faces over other points. Quads and larger faces are cut anew.
/// \throw InvalidMesh  a point is not finite.
SurfaceMesh with_points(const SurfaceMesh& mesh, const Points& points);

/// The poses that lead from `before` to `after`.
/// \throw InvalidConstraint  a pose of `before` has no inverse; the element of the error is the handle.
Poses relative_poses(const Poses& before, const Poses& after);

} // namespace sinew
