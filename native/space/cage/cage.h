// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

namespace sinew {

/// What becomes of points outside the cage, where a method has no weights.
enum class CageOutside {
    refuse,    ///< bind() names them
    mean_value ///< they get the weights of MeanValue; a warp jumps where the cage is crossed
};

/// A closed control mesh around, within or beside the points that it moves.
///
/// Faces of any size and any number of parts. Coordinates are written on the triangles that SurfaceMesh
/// cuts its faces into, but where a method says otherwise. Faces look outwards: the enclosed volume is
/// positive.
class Cage
{
public:
    /// \throw InvalidMesh  no face; an edge that its faces do not run along equally often in both directions
    ///                     (an open or an inconsistently oriented one; the vertices of such edges are named);
    ///                     a volume of zero or less, faces named: the cage is flat or inside out.
    explicit Cage(SurfaceMesh rest);

    const SurfaceMesh& rest() const { return rest_; }
    int vertex_count() const { return rest_.vertex_count(); }
    const std::vector<Triangle>& triangles() const { return rest_.triangles(); }

    /// Diagonal of the box around the rest vertices.
    double size() const { return size_; }

    /// \throw InvalidConstraint  `vertices` are not as many as the cage has, or one is not finite; they are
    /// named.
    void check_pose(PointsView vertices) const;

private:
    SurfaceMesh rest_;
    double size_;
};

} // namespace sinew
