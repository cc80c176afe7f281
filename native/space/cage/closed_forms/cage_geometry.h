// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/space/cage/cage.h"
#include "native/space/cage/closed_forms/cage_kernels.h"

#include <cstddef>
#include <vector>

namespace sinew {

/// What the closed forms over a cage's triangles share: the cage about its centre in units of its size, its
/// edges and the planes of its triangles. Triangles whose height is below 1e-8 of the cage's size have no
/// plane to speak of and are left out: what they would give is that small, what rounding makes of it is not.
class CageGeometry
{
public:
    /// \throw InvalidMesh  no triangle is left.
    explicit CageGeometry(const Cage& cage);

    CageTables tables() const;

    /// `point` about the centre, in units of the size.
    Vector3 seen(const Vector3& point) const { return (point - centre_) / size_; }
    /// x as seen; from farther than 1,000 sizes, the point there on its way to the centre. Closed forms lose
    /// digits with the cube of the distance: at that they keep half of them.
    Vector3 within_reach(const Vector3& x) const;

    /// Numbers that the kernels want for themselves.
    std::size_t scratch_size(const CageKernels& kernels) const
    {
        return static_cast<std::size_t>(kernels.lanes) * (4 * vertices_.size() / 3 + 2 * edges_.size());
    }

    /// The cage's triangle that the t-th one of the tables is.
    int cage_triangle(int t) const { return kept_[static_cast<std::size_t>(t)]; }

    /// Shares of the corners of triangle t, of the tables, at the foot of x (as seen); they sum to 1.
    Vector3 barycentric(int t, const Vector3& x) const;
    /// Height of x below triangle t's plane: positive behind it, where the cage is.
    double depth(int t, const Vector3& x) const;
    /// The first of the triangles closest to x.
    int nearest(const Vector3& x) const;
    /// Squared distance from triangle t.
    double square_distance(int t, const Vector3& x) const;

private:
    Vector3 vertex(int v) const { return Eigen::Map<const Vector3>(vertices_.data() + 3 * v); }

    Vector3 centre_;
    double size_;
    std::vector<double> vertices_;
    std::vector<CageEdge> edges_;
    std::vector<CageTriangle> triangles_;
    std::vector<int> kept_;
};

/// Points as seen, side by side for the kernels: x of all, y of all, z of all.
struct PointLanes
{
    int count;
    double lanes[3 * most_cage_lanes];

    explicit PointLanes(const CageKernels& kernels) : count(kernels.lanes) {}
    void set(int lane, const Vector3& x)
    {
        for (int axis = 0; axis < 3; ++axis)
            lanes[count * axis + lane] = x[axis];
    }
};

} // namespace sinew
