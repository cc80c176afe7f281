// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

#include <optional>
#include <vector>

namespace sinew {

/// A power of two near the size of points, or 1 if they have an ordinary size, 1e-5 to 1e5, or none. Lengths
/// in this unit have squares and volumes in single precision, too. No digit is lost by a power of two.
double normal_unit(const Points& points);

/// A mesh with all lengths divided by a power of two; nothing where that is 1, so that the mesh itself will do.
std::optional<SurfaceMesh> in_unit(const SurfaceMesh& mesh, double unit);

/// The same for points, in which coordinates below 1e-150 become 0: exact predicates cannot take numbers that
/// are too small to be normal.
std::vector<Vector3> points_in_unit(const PointsView& points, double unit);

/// Where a shape is computed with: as it is if its size is ordinary and it is near the origin; otherwise
/// relative to its middle and in its normal_unit().
class NormalFrame
{
public:
    NormalFrame() = default;
    explicit NormalFrame(const Points& points);

    bool is_identity() const { return unit_ == 1.0 && middle_.isZero(0.0); }
    double unit() const { return unit_; }
    /// A point in the frame. One farther away than 1e30 units, where products would overflow, is put there in
    /// the same direction.
    Vector3 in(const Vector3& point) const;
    /// The same for some points; they themselves if nothing changes.
    /// \param storage  holds the others.
    PointsView in(PointsView points, Points& storage) const;
    /// The same for a mesh.
    SurfaceMesh in(const SurfaceMesh& mesh) const;

private:
    Vector3 middle_ = Vector3::Zero();
    double unit_ = 1.0;
};

} // namespace sinew
