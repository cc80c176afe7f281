// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <array>
#include <vector>

namespace sinew {

using Corners = std::array<Vector3, 3>;

inline Corners corners_of(const std::vector<Vector3>& points, const Triangle& triangle)
{
    return {points[triangle[0]], points[triangle[1]], points[triangle[2]]};
}

/// Whether the corners are exactly on one line, or in one point.
bool is_flat(const Corners& triangle);

/// Whether two triangles, neither of them flat, have more points in common than the corners and edges that
/// they share by index. The answer is exact. Two triangles with the same three corners meet; two at a common
/// edge meet where one is folded onto the other.
bool triangles_meet(const Corners& a, const Triangle& a_indices, const Corners& b, const Triangle& b_indices);

/// All pairs (i < j) of triangles that meet, ascending; flat triangles are left out. Cost: O(n log n) for a
/// sweep along x, and a test for each pair of triangles that overlap along x.
std::vector<std::array<int, 2>> meeting_pairs(const std::vector<Vector3>& points,
                                              const std::vector<Triangle>& triangles);

/// How often the triangles wind around a point: 1 inside a closed surface whose faces look outward, 0
/// outside, and fractions where the surface is open (A. Jacobson et al., "Robust Inside-Outside
/// Segmentation", SIGGRAPH 2013). Cost: O(n).
double winding_number(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles,
                      const Vector3& at);

/// A tree of boxes around triangles, for quick answers about them. Flat triangles are left out. Any number of
/// threads may ask at once.
class TriangleTree
{
public:
    TriangleTree(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles);

    /// Whether a triangle touches or crosses one of the tree. Exact; false for a flat triangle.
    bool meets(const Corners& triangle) const;
    /// Whether the segment between two points touches or crosses a triangle of the tree. Exact; false for two
    /// equal points.
    bool meets(const Vector3& from, const Vector3& to) const;
    /// The closest point on the triangles, up to rounding. There must be a triangle.
    Vector3 closest(const Vector3& point) const { return closest_place(point).point; }

    /// A point on a triangle.
    struct Place
    {
        Vector3 point;
        int triangle; ///< its index among those that the constructor got
    };
    /// The closest point and its triangle, under the same condition.
    Place closest_place(const Vector3& point) const;

    /// How often a ray leaves through the front of a triangle, less how often it enters: 1 from inside a
    /// closed surface whose faces look outward, 0 from outside. A ray through an edge may count it twice.
    int crossings(const Vector3& from, const Vector3& direction) const;
    /// Whether there is no triangle, but for flat ones.
    bool empty() const;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew
