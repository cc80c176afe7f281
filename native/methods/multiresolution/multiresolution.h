// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/methods/multiresolution/details/bands.h"
#include "native/methods/surface/method.h"

#include <memory>
#include <string>
#include <vector>

namespace sinew {

/// Multiresolution deformation: another method moves a smooth base of the surface, and the details are put
/// back on it.
///
/// L. Kobbelt, S. Campagna, J. Vorsatz, H.-P. Seidel. "Interactive Multi-Resolution Modeling on Arbitrary
/// Meshes." SIGGRAPH 1998. M. Botsch, M. Pauly, L. Kobbelt, P. Alliez, B. Levy, S. Bischoff, C. Roessl.
/// "Geometric Modeling Based on Polygonal Meshes." Eurographics tutorial, 2008. Tutorial, section 4.4.
///
///     b_0 = y,  b_k = smooth(b_k-1)       implicit fairing of the shape y that enters (details/fairing.h)
///     b_n' = base method (b_n)
///     b_k-1' = details of b_k-1 over b_k, put on b_k';   x = b_0'      (details/detail_coding.h)
///
/// The base method gets the smooth shape as the one that enters its frame; its operators, which it computed
/// at bind, are those of the rest shape. So any method can be the base. One that displaces all shapes alike,
/// as the thin shell, solves for the rest shape instead, with its affine basis. Handles and open borders have
/// no details, so handles are met exactly, and a soft handle takes details away as far as it pulls.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   nothing
///   set_handles()  another set of handles        a bind of the base, and one factorisation per band; volumes
///                                                and transfer take one more per band
///   rebind()       other details, bands or       all but the base, which is kept
///                  wavelength
///   solve()        the handles moved             a frame of the base, mostly for an incoming shape, and the
///                                                details of each band; where a shape enters or a drag
///                                                starts from one, one solve more per band
///
/// What the base does not reproduce, this does not either; details turn with it where it bends or twists the
/// surface, also where it turns none itself, as the thin shell.
class Multiresolution final : public SurfaceMethodWith<MultiresolutionOptions>
{
public:
    /// \param base  a method on the same rest shape. It belongs to this object from now on; its handles
    ///   become those of this object.
    /// \throw InvalidOption  no base, or one on another rest shape; wavelength not > 0; bands not in [1, 8].
    Multiresolution(const SurfaceMesh& rest, std::shared_ptr<SurfaceMethod> base,
                    const MultiresolutionOptions& options = {});

    /// (bands + 1) the rest shape and what each band left of it, each (n, 3); the rest shape alone before
    /// set_handles().
    std::vector<Points> levels() const;

protected:
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    std::vector<std::string> changed_options(const SurfaceMethod& former) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew
