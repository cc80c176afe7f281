// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/memory.h"
#include "native/handles/constrained_system.h"
#include "native/methods/multiresolution/details/detail_coding.h"
#include "native/methods/multiresolution/details/ring_rotations.h"
#include "native/operators/turned_gradients.h"

#include <memory>
#include <vector>

namespace sinew {

/// Details by the deformation of the base itself: each triangle of the surface is mapped as its triangle of
/// the base was, and one Poisson equation finds the surface that comes closest to these.
///
/// R. Sumner, J. Popovic. "Deformation Transfer for Triangle Meshes." SIGGRAPH 2004. M. Botsch, R. Sumner,
/// M. Pauly, M. Gross. "Deformation Transfer for Detail-Preserving Surface Editing." VMV 2006. Tutorial,
/// section 4.4.4.
///
///     G^T D G x' = G^T D (G x T_f^T),   T_f = [e1' e2' s n'] [e1 e2 n]^-1,   s = sqrt(area' / area)
///
/// T_f is the map of a triangle of the base; a triangle without area takes the rotation of its ring. Departs
/// from the papers by s, which makes similarities exact; with s = 1 only rigid maps are. Affine maps are not:
/// the details do not lie in the planes of the base, in which alone T_f knows the map. Where the base is
/// held, x' = b'; vertices that handles pull softly are pulled to where their vectors lead.
///
///   call         cost
///   constructor  one Poisson factor
///   apply()      O(n), and one solve for x, y and z
class DeformationTransfer final : public DetailCoding
{
public:
    /// \param regions       those of the fairing.
    /// \param fine, coarse  (n, 3) the band at rest.
    /// \throw FactorizationFailed  the element is a vertex.
    DeformationTransfer(const SurfaceMesh& rest, const Regions& regions, const PointsView& fine,
                        const PointsView& coarse, std::shared_ptr<const RingRotations> rings);

    void apply(const Band& band, Points& detailed, SolveReport& report) const override;
    void report(BindReport& report) const override;

private:
    /// Two edges of a triangle of the surface, each as a sum of the two edges of its triangle of the base and
    /// of their cross product N over the root of its length. T_f takes them to the same sums after the
    /// deformation.
    struct Edges
    {
        Vector3 first, second;
        bool flat; ///< the triangle of the base has no area, and this nothing
    };
    Edges edges_of(const PointsView& fine, const PointsView& coarse, int triangle) const;

    struct Workspace
    {
        Points aims;
        std::vector<Vector3> forces;
    };

    std::shared_ptr<const RingRotations> rings_;
    std::vector<int> soft_; ///< vertices
    TurnedGradients gradients_;
    ConstrainedSystem system_;
    Poses still_;
    std::vector<bool> from_aims_;
    std::vector<Edges> edges_; ///< at rest
    mutable Pool<Workspace> workspaces_;
};

} // namespace sinew
