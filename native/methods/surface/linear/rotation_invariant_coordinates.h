// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/methods/surface/method.h"
#include "native/operators/laplacian.h"

#include <string>
#include <vector>

namespace sinew {

struct RotationInvariantCoordinatesOptions
{
    Discretization laplacian = Discretization::cotan;

    static constexpr auto table()
    {
        using O = RotationInvariantCoordinatesOptions;
        return std::tuple{option("laplacian", &O::laplacian, Rebind::anew,
                                 "'uniform' or 'cotan' (section 3.2): the weights of the edges")};
    }
};

/// Rotation-invariant coordinates: local frames first, then positions, each by one linear system.
///
/// Y. Lipman, O. Sorkine, D. Levin, D. Cohen-Or. "Linear Rotation-Invariant Coordinates for Meshes."
/// SIGGRAPH 2005. Tutorial, section 4.5.3.
///
/// The frames f'_i of the vertices keep their rotations R_ij to their neighbours' frames as well as they can,
/// and the edges keep their coordinates in them:
///
///     sum_ij w_ij |f'_j - f'_i R_ij|^2,
///     then    E(x) = 1/2 sum_ij w_ij |x_i - x_j - 1/2 (Q_i + Q_j) (y_i - y_j)|^2
///
/// over the edges, with base points y (the incoming shape, or the rest shape). With f'_i = Q_i f_i, the first
/// sum is sum w_ij |Q_i - Q_j|^2, whatever the frames f_i of rest are: Q is harmonic, entry by entry, and Q_i
/// = sum_h s_h(i) R_h with the harmonic fields s_h of the handles (see handles/handle_fields.h) and the
/// rotations R_h of their maps. So no frames are solved for in a frame of the animation. Q_i is then replaced
/// by the rotation closest to it. Soft handles add s_i |x_i - t_i|^2 / 2 with s_i = w / (1 - w)
/// L_ii, and pull frames as much.
///
/// Departs from the paper: normals and tangents, which describe a frame there, do not enter. In the first
/// sum, negative weights are made positive, so that frames stay between those of the handles. Where det Q_i
/// is below 1e-3, because handles are turned against each other by about half a turn, there is no closest
/// rotation, and Q_i is the mean of their rotation vectors (see handles/map_blend.h); the report counts these
/// vertices.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   nothing
///   set_handles()  another set of handles        one factorisation, and one solve of as many columns as
///                                                handles less one; one more factorisation where a weight
///                                                is negative
///   solve()        the handles moved             one solve for x, y and z, and one rotation fit per vertex
///
/// Rigid motions of all handles together are reproduced; scale and shear of a handle reach its own vertices
/// alone. Translations have no influence on frames: where handles are moved but not turned, the surface
/// between them is sheared. Suits bends and twists of less than half a turn between neighbouring handles.
class RotationInvariantCoordinates final : public SurfaceMethodWith<RotationInvariantCoordinatesOptions>
{
public:
    /// \throw InvalidOption  cotan_voronoi, whose masses have no place here.
    explicit RotationInvariantCoordinates(const SurfaceMesh& rest,
                                          const RotationInvariantCoordinatesOptions& options = {});

protected:
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew
