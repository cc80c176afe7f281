// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <array>
#include <memory>
#include <vector>

namespace sinew {

using Corners = std::array<Vector3, 3>;

inline Corners corners_of(const std::vector<Vector3>& points, const Triangle& triangle)
{
    return {points[triangle[0]], points[triangle[1]], points[triangle[2]]};
}

/// Corners exactly on one line, or in one point.
bool is_flat(const Corners& triangle);

/// Whether two triangles, neither of them flat, have more in common than the corners and edges that they
/// share by index. Exact. Triangles of the same three corners do; two at an edge do where one lies on the
/// other.
bool triangles_meet(const Corners& a, const Triangle& a_indices, const Corners& b, const Triangle& b_indices);

/// All pairs (i < j) of triangles that meet, ascending; flat ones are left out. A sweep along x: O(n log n)
/// and the pairs that overlap there.
std::vector<std::array<int, 2>> meeting_pairs(const std::vector<Vector3>& points,
                                              const std::vector<Triangle>& triangles);

/// How often the triangles go round a point: 1 inside a closed surface that looks outward, 0 outside, and a
/// share of it where the surface is open (A. Jacobson et al., "Robust Inside-Outside Segmentation", SIGGRAPH
/// 2013). O(n).
double winding_number(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles,
                      const Vector3& at);

/// Answers by a tree of boxes; flat triangles are left out. Any number of threads may ask.
class TriangleTree
{
public:
    TriangleTree(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles);
    ~TriangleTree();
    TriangleTree(TriangleTree&&) noexcept;

    /// Exact; false for a flat one.
    bool meets(const Corners& triangle) const;
    /// The point of the triangles that is closest, up to rounding. There must be a triangle.
    Vector3 closest(const Vector3& point) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace sinew
