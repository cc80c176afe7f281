// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/trees/triangle_tree.h"

#include <vector>

namespace sinew {

/// The solid angle of a triangle as seen from a point, positive where its back is seen.
double solid_angle(const Corners& triangle, const Vector3& at);

/// winding_number() of the same triangles for many points: groups of triangles that are far away count by
/// the first two terms of their series, in which each triangle is a dipole at its centroid.
///
/// G. Barill et al. "Fast Winding Numbers for Soups and Clouds." SIGGRAPH 2018.
///
/// A group is far where it is four times as far away as it is large; the errors stay below 0.02 then. Any
/// number of threads may ask at once.
///
///   call         cost
///   constructor  O(n log n)
///   at()         O(log n)
class WindingTree
{
public:
    WindingTree(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles);

    double at(const Vector3& point) const;

private:
    struct Node
    {
        Vector3 centre;  ///< mean of the centroids, by their areas
        double radius;   ///< of a ball around it that has all triangles
        Vector3 normal;  ///< N = sum_t A_t n_t
        Matrix3 moment;  ///< sum_t A_t n_t (c_t - centre)^T
        int begin, end;  ///< triangles
        int second = 0;  ///< of its halves; the first one is the next node; 0 for a leaf
    };
    void build(int begin, int end);

    std::vector<Corners> triangles_; ///< in the order of the leaves
    std::vector<Node> nodes_;
};

} // namespace sinew
