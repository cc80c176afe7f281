// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <Eigen/Geometry>

#include <vector>

namespace sinew {

/// Which triangle is closest to a point, where some distance is known that is hardly longer: quicker than
/// TriangleTree for the points of a surface that was smoothed, and with its answers. Flat triangles are left
/// out. Any number of threads may ask at once.
class ClosestTriangle
{
public:
    /// The triangles in boxes of four along a curve that fills space, these in boxes of four, and so on.
    /// Cost: O(n). Both arguments must outlive this.
    ClosestTriangle(const PointsView& points, const std::vector<Triangle>& triangles);

    /// Of several that are equally close, the first; -1 if there is none nearer than `limit`.
    int to(const Vector3& point, double limit) const;

private:
    using Box = Eigen::AlignedBox3d;

    static constexpr int width = 4; ///< what a box holds

    PointsView points_;
    const std::vector<Triangle>& triangles_;
    std::vector<int> order_; ///< of the triangles
    std::vector<std::vector<Box>> levels_; ///< from the boxes around triangles to one around all
};

/// The square of the distance from a point to a triangle. C. Ericson. "Real-Time Collision Detection",
/// section 5.1.5.
double squared_distance(const Vector3& point, const Vector3& a, const Vector3& b, const Vector3& c);

} // namespace sinew
