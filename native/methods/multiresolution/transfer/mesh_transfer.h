// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/report.h"
#include "native/core/types.h"
#include "native/mesh/components.h"
#include "native/mesh/surface_mesh.h"
#include "native/methods/multiresolution/details/deformation_transfer.h"

#include <memory>
#include <vector>

namespace sinew {

/// Carries the deformation of one mesh over to another with the same faces and other proportions.
///
/// R. Sumner, J. Popovic. "Deformation Transfer for Triangle Meshes." SIGGRAPH 2004. Tutorial, section 4.4.4.
///
/// Each triangle of the target is mapped as its triangle of the source, by the equation of
/// DeformationTransfer. It leaves open where each part of the target goes; its centre of area c moves with
/// that of the source, C, as the source moves as a whole:
///
///     c' = Q c + s (C' - Q C)
///
/// Q is the rotation that is closest to the maps of all triangles, and s the root of the ratio of the areas,
/// so a target of twice the size takes steps of twice the length. A source that is moved rigidly, or a target
/// that is the source in another size, follows exactly.
///
///   call         repeat it when ...     cost
///   constructor  a rest shape changed   one Poisson factor
///   transfer()   the source moved       O(n), and one solve for x, y and z; safe from several threads
class MeshTransfer
{
public:
    /// \throw InvalidMesh          the target has another number of vertices, or other faces; the elements
    ///   are the faces that differ.
    /// \throw FactorizationFailed  the element is a vertex.
    MeshTransfer(const SurfaceMesh& source, const SurfaceMesh& target);

    /// \param source       (n, 3) the source, deformed.
    /// \param[out] target  (n, 3) the target, deformed alike.
    /// \throw InvalidConstraint  the source has another number of points, or one is not finite.
    void transfer(const PointsView& source, Points& target) const;

    int vertex_count() const { return static_cast<int>(source_.rows()); }

private:
    Points source_, target_; ///< at rest
    Components parts_;
    std::shared_ptr<const RingRotations> rings_;
    std::unique_ptr<DeformationTransfer> faces_;
    VectorX shares_, target_shares_; ///< (n) of the area of a vertex's part; their sums over a part are 1
    Points centres_, target_centres_; ///< (k) of the parts at rest
    double scale_ = 1.0;
};

} // namespace sinew
