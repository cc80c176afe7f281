// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/trees/triangle_tree.h"

#include <vector>

namespace sinew {

struct MirrorPlane
{
    int axis = -1; ///< 0 to 2: the plane is perpendicular to it; -1 for none
    double offset = 0.0; ///< the plane's coordinate along the axis
    double deviation = 0.0; ///< the greatest distance from the mirror image of a vertex to the triangles
    bool through_origin = false;
};

/// Finds out how symmetric triangles of size 1 are whose centroid is at 0. The surface counts, not
/// the vertices, so both sides may be divided differently.
///
/// 100 vertices, evenly spaced in the list, choose the plane, and 2000 measure it. Only where they find the
/// sides alike are all vertices asked, so that a target without symmetry costs little. Cost: up to six
/// queries for each of the 100.
class MirrorTest
{
public:
    /// \param count  how many of the points, from the first, are asked about
    /// \param tree   of the triangles
    MirrorTest(const std::vector<Vector3>& points, int count, const TriangleTree& tree);

    /// The plane through the object's origin or the centroid whose sides differ least. Of those
    /// that are equal to 1e-3, the earlier axis, and the origin, is preferred.
    ///
    /// \param origin     of the object, in the coordinates of the triangles
    /// \param axis       the only one allowed, or -1
    /// \param tolerance  up to here the deviation is that of all points, beyond it that of 2000
    MirrorPlane best(const Vector3& origin, int axis, double tolerance) const;

private:
    double deviation(int axis, double offset, int step) const;

    const std::vector<Vector3>& points_;
    int count_;
    const TriangleTree& tree_;
};

} // namespace sinew
