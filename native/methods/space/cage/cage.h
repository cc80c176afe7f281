// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/mesh/flat_outline.h"
#include "native/mesh/frames/normal_frame.h"
#include "native/methods/space/cage/smooth/smooth_cage.h"

#include <memory>
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
///
/// A cage may be smooth: then its limit surface moves the points, as a mesh of quads that SmoothCage makes.
/// Coordinates are computed for the vertices of that mesh, and folded to weights of the control points, the
/// cage's own vertices. Without that, the vertices are the control points.
class Cage
{
public:
    /// \param may_be_flat  whether the method takes flat cages.
    /// \throw InvalidMesh  there is no face; or the cage is flat and must not be, or its outline crosses
    ///   itself; or faces run along an edge more often in one direction than in
    ///   the other, which means that the cage is open or that neighbouring faces look to different sides (the
    ///   vertices of such edges are named); or the volume is not positive, which means that the cage is flat
    ///   or inside out (faces are named).
    /// \throw InvalidMesh, InvalidOption, OutOfMemory  as SmoothCage.
    explicit Cage(SurfaceMesh rest, bool may_be_flat = false, const CageSmoothing& smoothing = {});

    bool is_flat() const { return outline_.has_value(); }
    /// Of a flat cage.
    const FlatOutline& outline() const { return *outline_; }

    /// The rest cage in its own frame(), in which all coordinates are computed. So neither its size nor its
    /// place matters. Of a smooth cage, its smooth surface.
    const SurfaceMesh& rest() const { return rest_; }
    /// The rest cage as it was given, with the control points.
    const SurfaceMesh& given() const { return given_ ? *given_ : rest_; }
    const NormalFrame& frame() const { return frame_; }
    int vertex_count() const { return rest_.vertex_count(); } ///< of rest()
    int control_count() const { return given().vertex_count(); }
    /// (control_count(), 3) the control points in frame().
    const Points& control() const { return smooth_ ? control_ : rest_.points(); }
    /// The face as it was given that a face of rest() is, or is a part of.
    int given_face(int face) const { return smooth_ ? smooth_->control_face(face) : face; }
    const std::vector<Triangle>& triangles() const { return rest_.triangles(); }

    /// Diagonal of the box around the vertices of rest().
    double size() const { return size_; }

    /// None unless the cage is smooth. Its unit is that of frame().
    const std::shared_ptr<const SmoothCage>& smooth() const { return smooth_; }
    /// The smooth surface of the cage as it was given; none for other cages.
    std::optional<SurfaceMesh> smooth_mesh() const;
    /// The vertices of rest() for posed control points.
    /// \param storage  holds them where the cage is smooth.
    PointsView refined(PointsView control, Points& storage) const;
    /// Takes weights of the vertices, the first columns of some rows, to weights of the control points.
    void fold(RowMatrix& rows) const
    {
        if (smooth_)
            smooth_->fold(rows);
    }
    const CageSmoothing& smoothing() const { return smoothing_; }

    /// \throw InvalidConstraint  there are more or fewer control points than the cage has, or some are not
    ///   finite.
    void check_pose(PointsView vertices) const;

private:
    CageSmoothing smoothing_;
    NormalFrame frame_;
    SurfaceMesh rest_;
    std::shared_ptr<const SmoothCage> smooth_;
    std::optional<SurfaceMesh> given_; ///< where the frame is not the identity, or the cage is smooth
    Points control_;                   ///< where the cage is smooth
    std::optional<FlatOutline> outline_;
    double size_;
};

} // namespace sinew
