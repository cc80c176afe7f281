// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"
#include "native/methods/multiresolution/details/bands.h"
#include "native/methods/space/handle_points/handle_points.h"
#include "native/methods/space/method.h"

#include <memory>
#include <string>
#include <vector>

namespace sinew {

/// Multiresolution deformation by a space method: it moves a smooth base of a mesh, and the details are put
/// back on it, where they turn with the base.
///
/// M. Marinov, M. Botsch, L. Kobbelt. "GPU-Based Multiresolution Deformation Using Approximate Normal Field
/// Reconstruction." Journal of Graphics Tools 12(1), 2007. Tutorial, sections 4.4 and 5.3.
///
///     b = smooth(x),   b' = space method (b),   x' = details of x over b, put on b'
///
/// A linear space method shears details where it bends the space; here they keep their shape. The bands and
/// the codings are those of multiresolution.h. Vertices at handle points have no details, so handles are met
/// as the space method meets them; nor have open borders. Parts of the mesh without a handle point have no
/// details either: the space method moves their vertices themselves.
///
/// Departs from the paper, which finds the normals of the deformed base by the derivatives of the
/// deformation: the rotations are fitted to the rings of the base.
///
///   call          repeat it when ...       cost
///   constructor   the handles changed      nothing
///   bind()        the points changed       a bind of the space method, and one factorisation per band;
///                                          volumes and transfer take one more per band
///   warp()        the handles moved        a frame of the space method, and the details of each band
class MultiresolutionSpace final : public SpaceMethod
{
public:
    /// \param handles  those of `base`.
    /// \param base     a space method that takes the same control. It belongs to this object from now on.
    /// \param mesh     the rest shape, whose vertices can be bound, all or some.
    /// \throw InvalidOption  no base; wavelength not > 0; bands not in [1, 8].
    MultiresolutionSpace(HandlePoints handles, std::shared_ptr<SpaceMethod> base, const SurfaceMesh& mesh,
                         const MultiresolutionOptions& options = {});
    ~MultiresolutionSpace() override;

    const HandlePoints& handles() const { return handles_; }

protected:
    void compute(PointsView points, SpaceReport& report, const Progress& progress) override;
    void displace(PointsView control, PointsView base, PositionsOut out) const override;
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;
    void swap_weights(SpaceMethod& other) override;

private:
    struct Binding;

    HandlePoints handles_;
    std::shared_ptr<SpaceMethod> base_;
    SurfaceMesh mesh_;
    MultiresolutionOptions options_;
    std::shared_ptr<const Binding> bound_;
};

} // namespace sinew
