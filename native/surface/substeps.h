// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"

#include <vector>

namespace sinew {

/// (k) the mean of the vertices of each handle in a shape.
std::vector<Vector3> handle_centres(const Regions& regions, const PointsView& shape);

/// Poses on the way from rest: rotations by the shorter way at a constant speed (of two ways of half a turn,
/// by that of rotation_between()), scales and the centres of the handles along straight lines.
class PathOfPoses
{
public:
    PathOfPoses(const Poses& poses, std::vector<Vector3> centres);

    /// \param share  of the way, in [0, 1].
    Poses at(double share) const;

private:
    struct Way
    {
        Vector3 turn; ///< a rotation vector
        Matrix3 scale;
        Vector3 from, to;
    };
    std::vector<Way> ways_;
};

/// The same faces over other points. Quads and larger faces are cut anew.
/// \throw InvalidMesh  a point is not finite.
SurfaceMesh with_points(const SurfaceMesh& mesh, const Points& points);

/// The poses that lead from `before` to `after`.
/// \throw InvalidConstraint  a pose of `before` has no inverse; the element of the error is the handle.
Poses relative_poses(const Poses& before, const Poses& after);

} // namespace sinew
