// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

#include <vector>

namespace sinew {

/// Where a surface is, how it lies and how large it is, by the moments of its area: loose vertices count
/// nothing, and neither the axes of the coordinates, nor how the surface is divided, nor, unless the surface
/// is symmetric, the order of its faces matters. Whatever is a share of the size of a surface is a share of
/// this `size`.
struct SurfaceFrame
{
    Vector3 centre = Vector3::Zero(); ///< the centroid of the area
    /// Columns: along which the surface is spread most, second and least; a rotation. Each points to where
    /// the surface reaches farther; the one of which that is least clear completes the rotation. What a
    /// symmetry leaves open, the first point decides that reaches farthest, or that is not on the plane.
    Matrix3 axes = Matrix3::Identity();
    /// The axis that was turned round to complete the rotation, or -1.
    Eigen::Index mirrored = -1;
    /// Four times the root mean square of the distance from the centre: of most shapes, the diagonal of a
    /// box around them to some per cent. 1 where all is in one place.
    double size = 1.0;

    /// (3) a point in this frame.
    Vector3 in(const Vector3& point) const { return axes.transpose() * (point - centre); }
    /// (3) a point of this frame in the coordinates of the surface.
    Vector3 out(const Vector3& point) const { return centre + axes * point; }
};

/// The frame of all faces. Without any area, the edges of the faces count, and without any length, all
/// points.
SurfaceFrame surface_frame(const SurfaceMesh& mesh);

/// The frame of points that have weights >= 0, some of them > 0.
SurfaceFrame frame_of_points(const std::vector<Vector3>& points, const std::vector<double>& weights);

/// (n) the size of the part that each vertex is in. So a part is as stiff as it is alone. A part in one place
/// has the size of the largest one.
std::vector<double> part_sizes(const SurfaceMesh& mesh);

/// (n) the points in an order that depends on where they are in the frame: on their distances from the
/// centre, then on where they are along the axes, of which none is turned round to complete a rotation, so
/// that a mirrored shape has the same order, all in steps of 1.5e-5 of the size, and in the end on their
/// indices. So geometry decides between points that are equally good for something, and neither their order
/// nor their last bits do.
std::vector<int> order_by_place(PointsView points, const SurfaceFrame& frame);

/// The same for the vertices of a mesh, each in the frame of its own part, so that no part changes the order
/// within another one.
std::vector<int> order_by_place(const SurfaceMesh& mesh);

} // namespace sinew
