// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/handles/handle_fields.h"
#include "native/handles/system_solver.h"
#include "native/methods/surface/method.h"

#include <string>
#include <vector>

namespace sinew {

struct GradientEditingOptions
{
    Field field = Field::harmonic;
    SystemSolver solver = SystemSolver::automatic;

    static constexpr auto table()
    {
        using O = GradientEditingOptions;
        return std::tuple{
            option("field", &O::field, Rebind::update,
                   "how the maps of the handles fade: 'harmonic' (Eq. 8), or by the distances from them: "
                   "'geodesic' along the surface, 'euclidean' in a straight line"),
            solver_option(&O::solver)};
    }
};

/// Gradient-based editing: the handles turn the gradients of the surface, and one Poisson equation finds the
/// surface whose gradients come closest to these.
///
/// Y. Yu et al. "Mesh Editing with Poisson-Based Gradient Field Manipulation." SIGGRAPH 2004.
/// R. Zayer, C. Roessl, Z. Karni, H.-P. Seidel. "Harmonic Guidance for Surface Deformation." Eurographics
/// 2005. Tutorial, sections 4.5.1 and 4.5.3. On the multigrid:
/// L. Shi, Y. Yu, N. Bell, W.-W. Feng. "A Fast Multigrid Algorithm for Mesh Deformation." ACM Transactions on
/// Graphics 25(3), 2006.
///
/// With base points y (the incoming shape, or the rest shape), gradients G_t of y on each triangle of area
/// A_t, and one linear map T_t per triangle, it minimises
///
///     E(x) = 1/2 sum_t A_t |grad x - G_t T_t^T|^2        (Eq. 15: G^T D G x = G^T D G')
///
/// T_t blends the linear maps of the handles (see handles/map_blend.h): for one handle that moves by R S
/// beside fixed ones, T = slerp(I, R, s) (s S + (1 - s) I), Eq. 16 with its scale factor corrected. s is the
/// field of the handle (see handles/handle_fields.h), averaged over the corners. A triangle that touches held
/// vertices of one handle alone has exactly the map of that handle. Soft handles add s_i |x_i - t_i|^2 / 2
/// with s_i = w / (1 - w) L_ii.
///
/// Departs from the papers: several handles are blended at once, and gradients are turned by the transpose,
/// as they have to be (the tutorial has T itself). Areas and angles are those of the rest shape. A triangle
/// without area has the metric of operators/laplacian.h on both sides of the equation, so that it does no
/// harm.
///
/// With `solver="multigrid"` both passes of Shi et al. are iterations on a hierarchy of graphs (solvers/multigrid): first
/// the maps of the handles are propagated, by the fields from Eq. 8, L s = 0 with the positive weights of
/// operators/laplacian.h, then positions follow from them, by Eq. 15. The shape is that of the factor to 1e-4 of the
/// motion, and with SolveRequest::start it differs by as much from call to call. Departs from their paper: each map is
/// the blend above, where they propagate frames as vectors; the hierarchy is that of this library, and its cycles are a
/// preconditioner of conjugate gradients.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   nothing
///   set_handles()  another set of handles        one factorisation, and the fields: with `harmonic` one
///                                                solve of as many columns as handles less one, and one more
///                                                factorisation where a cotangent weight is negative, with
///                                                distances O(n log n) per handle
///   solve()        the handles moved             one solve for x, y and z, and one map per triangle
///   set_handles()  another set of handles        with the multigrid a hierarchy, O(n); two where a cotangent
///                                                weight is negative; and the fields, 2 to 6 iterations
///   solve()        the handles moved             with the multigrid 2 to 6 iterations
///
/// At a million vertices bind and first frame take 13 to 27 % less work on the multigrid, every further frame takes
/// three to six times as much (docs/developer/decisions/multigrid-on-graphs.md). The system of a solve needs the factor.
///
/// Affine motions of all handles together are reproduced. Translations have no influence on gradients: where
/// handles are moved but not turned, the surface between them is sheared. Suits bends and twists of less than
/// half a turn between neighbouring handles.
class GradientEditing final : public SurfaceMethodWith<GradientEditingOptions>
{
public:
    explicit GradientEditing(const SurfaceMesh& rest, const GradientEditingOptions& options = {});

protected:
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew
