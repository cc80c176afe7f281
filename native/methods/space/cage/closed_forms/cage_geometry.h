// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/cage/cage.h"
#include "native/methods/space/cage/closed_forms/cage_kernels.h"

#include <cstddef>
#include <vector>

namespace sinew {

/// What the closed forms over a cage's triangles share: its vertices, edges, and the planes of its triangles.
/// Points are normalised: relative to the centre of the cage, in units of its size. Triangles whose height is
/// below 1e-8 of the size are left out: their contribution is negligible, but its rounding error is not.
class CageGeometry
{
public:
    /// \param without  which faces of the cage to leave out; empty for none.
    /// \throw InvalidMesh  no triangle is left, and no face was left out.
    explicit CageGeometry(const Cage& cage, const std::vector<char>& without = {});

    CageTables tables() const;

    Vector3 normalized(const Vector3& point) const { return (point - centre_) / size_; }
    /// The normalised point x, or if it is farther from the centre than 1,000 sizes, the point at that
    /// distance in the same direction. Closed forms lose digits with the cube of the distance; there they
    /// still have half of them.
    Vector3 within_reach(const Vector3& x) const;

    /// Size of the scratch memory that the kernels need.
    std::size_t scratch_size(const CageKernels& kernels) const
    {
        return static_cast<std::size_t>(kernels.lanes) * (4 * vertices_.size() / 3 + 2 * edges_.size());
    }

    /// The index that triangle t of the tables has in the cage.
    int cage_triangle(int t) const { return kept_[static_cast<std::size_t>(t)]; }

    // In what follows, t is a triangle of the tables and x a normalised point.

    /// The barycentric coordinates of the foot of x in the plane of triangle t.
    Vector3 barycentric(int t, const Vector3& x) const;
    /// The height of x below the plane of triangle t: positive behind it, where the inside of the cage is.
    double depth(int t, const Vector3& x) const;
    /// The triangle closest to x; of several, the first; -1 if there is none.
    int nearest(const Vector3& x) const;
    /// The squared distance of x from triangle t.
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

/// Normalised points, one per lane, in the layout of the kernels: x of all, then y of all, then z of all.
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
