// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/mesh/flat_outline.h"
#include "native/mesh/frames/normal_frame.h"

#include <optional>

namespace sinew {

/// What to do with points outside the cage, where a method has no weights.
enum class CageOutside {
    refuse,    ///< bind() throws an error that names them
    mean_value ///< they get the weights of MeanValue; a warp is not continuous across the cage
};
constexpr auto choices(CageOutside)
{
    return std::array{Choice{"error", CageOutside::refuse}, Choice{"mean_value", CageOutside::mean_value}};
}

/// A closed control mesh around, within or beside the points that it moves.
///
/// It has faces of any size, and any number of parts. Coordinates are defined on the triangles that
/// SurfaceMesh cuts its faces into, unless a method says otherwise. Faces look outwards, so the enclosed
/// volume is positive.
///
/// Some methods also take a flat cage: a mesh in a plane, whose outline is what moves the points in that
/// plane.
class Cage
{
public:
    /// \param may_be_flat  whether the method takes flat cages.
    /// \throw InvalidMesh  there is no face; or the cage is flat and must not be, or its outline crosses
    ///   itself; or faces run along an edge more often in one direction than in
    ///   the other, which means that the cage is open or that neighbouring faces look to different sides (the
    ///   vertices of such edges are named); or the volume is not positive, which means that the cage is flat
    ///   or inside out (faces are named).
    explicit Cage(SurfaceMesh rest, bool may_be_flat = false);

    bool is_flat() const { return outline_.has_value(); }
    /// Of a flat cage.
    const FlatOutline& outline() const { return *outline_; }

    /// The rest cage in its own frame(), in which all coordinates are computed. So neither its size nor its
    /// place matters.
    const SurfaceMesh& rest() const { return rest_; }
    /// The rest cage as it was given.
    const SurfaceMesh& given() const { return given_ ? *given_ : rest_; }
    const NormalFrame& frame() const { return frame_; }
    int vertex_count() const { return rest_.vertex_count(); }
    const std::vector<Triangle>& triangles() const { return rest_.triangles(); }

    /// Diagonal of the box around the vertices of rest().
    double size() const { return size_; }

    /// \throw InvalidConstraint  there are more or fewer vertices than the cage has, or some are not finite.
    void check_pose(PointsView vertices) const;

private:
    NormalFrame frame_;
    SurfaceMesh rest_;
    std::optional<SurfaceMesh> given_; ///< where the frame is not the identity
    std::optional<FlatOutline> outline_;
    double size_;
};

} // namespace sinew
