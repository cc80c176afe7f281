// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/handles/handle_fields.h"
#include "native/methods/surface/method.h"

#include <string>
#include <vector>

namespace sinew {

struct PropagationOptions
{
    Field field = Field::harmonic;
    std::vector<double> transfer{0.0, 1.0}; ///< see TransferCurve

    static constexpr auto table()
    {
        using O = PropagationOptions;
        return std::tuple{
            option("field", &O::field, Rebind::update,
                   "s: 'harmonic' (Eq. 8), or by distances: 'geodesic' along the surface, 'euclidean' in a "
                   "straight line"),
            option("transfer", &O::transfer, Rebind::update, any_number(),
                   "(k,) values of t(s) at even steps from s = 0 to s = 1, k >= 2; None for t(s) = s")};
    }
};

/// Transformation propagation: the motions of the handles fade over the surface.
///
/// G. Bendels, R. Klein. "Mesh Forging: Editing of 3D-Meshes Using Implicitly Defined Occluders." SGP 2003.
/// M. Pauly, R. Keiser, L. Kobbelt, M. Gross. "Shape Modeling with Point-Sampled Geometry." SIGGRAPH 2003.
/// Tutorial, section 4.2.
///
/// A handle takes its points y to c + R S (y - c) + m, with its centre c (the mean of its vertices), the move
/// m of the centre, and the polar decomposition of its linear map. With t = t(s(y)), the share of the handle
/// at y, its rotation, scale and move are damped apart:
///
///     x = c + slerp(I, R, t) (t S + (1 - t) I) (y - c) + t m
///
/// About the origin instead of c, a turn would become a translation. s is the field of the handle (see
/// handles/handle_fields.h). Held vertices go where their handle takes them.
///
/// Departs from the papers: several handles are blended. Rotations and scales are those of
/// handles/map_blend.h, with a weight of 1 - sum_h t_h on the identity; moves add up; and c is the mean of
/// the centres, weighted by t_h |R_h S_h - I|^2, so that it is the centre of the one handle that turns beside
/// others that rest. With t(s) = s, an affine map of all handles together is reproduced.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   nothing
///   set_handles()  another set of handles        with `harmonic` one factorisation and one solve of as many
///                                                columns as handles less one, with distances O(n log n) per
///                                                handle
///   solve()        the handles moved             O(n k) for k handles
///
/// There are no equations per frame, so nothing keeps the surface smooth or stiff: it follows the shape of
/// the field. Suits quick edits around one handle.
class Propagation final : public SurfaceMethodWith<PropagationOptions>
{
public:
    /// \throw InvalidOption  `transfer` has less than two values, or one that is not finite.
    explicit Propagation(const SurfaceMesh& rest, const PropagationOptions& options = {});

protected:
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew
