// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/handles/constrained_system.h"
#include "native/handles/system_solver.h"
#include "native/methods/surface/linear/responses/affine_basis.h"
#include "native/methods/surface/method.h"
#include "native/operators/laplacian.h"

#include <memory>
#include <string>
#include <vector>

namespace sinew {

/// One number, or one per vertex (painted). Painted values below 1e-6 of the largest one are raised to that,
/// so that the system stays solvable where a region is painted black.
using Stiffness = std::vector<double>;

struct ThinShellOptions
{
    Stiffness stretching{0.0};
    Stiffness bending{1.0};
    Stiffness variation{0.0};
    Discretization laplacian = Discretization::cotan_voronoi;
    bool affine_basis = true; ///< only where there are at most 16 handles
    SystemSolver solver = SystemSolver::automatic;

    static constexpr auto table()
    {
        using O = ThinShellOptions;
        return std::tuple{
            painted_option("stretching", &O::stretching, Rebind::update, at_least(0),
                           "k_s: a membrane, of order 1"),
            painted_option("bending", &O::bending, Rebind::update, at_least(0),
                           "k_b: a thin plate, of order 2; in units of k_s length^2"),
            painted_option("variation", &O::variation, Rebind::update, at_least(0),
                           "k_v: minimum variation of curvature, of order 3; in units of k_s length^4"),
            option("laplacian", &O::laplacian, Rebind::anew,
                   "'uniform', 'cotan', 'cotan_voronoi' or 'robust' (section 3.2)"),
            option("affine_basis", &O::affine_basis, Rebind::update,
                   "whether to precompute the response to affine handle motions, which makes a frame one "
                   "small matrix product with the same result; never with the multigrid"),
            solver_option(&O::solver)};
    }
};

/// Linear thin shell: the smoothest displacement field that meets the handles.
///
/// M. Botsch, L. Kobbelt. "An Intuitive Framework for Real-Time Freeform Modeling."
/// ACM Transactions on Graphics 23(3), 2004. Tutorial, section 4.3.
///
/// With rest points x and deformed points x + d it minimises
///
///     E(d) = 1/2 k_s |grad d|^2 + 1/2 k_b |Delta d|^2 + 1/2 k_v |grad Delta d|^2,
///     A    = L_ks + L (k_b C / M) L + L (C / M) L_kv (C / M) L,     A d = 0 on free vertices,
///
/// whose Euler-Lagrange equation is -k_s Delta d + k_b Delta^2 d - k_v Delta^3 d = 0 (Eq. 12).
/// L and M are those of operators/laplacian.h; a painted k scales the elements or vertices of
/// its own term.
///
/// Continuity, as in the paper: C is 1 on free vertices and min(c_h, 1) on those of handle h, so that
/// below c_h = 1 the handle's own curvature counts less and less, and the surface may leave it with a
/// crease (C0). In L_kv, triangles without a free vertex are scaled by min(max(c_h - 1, 0), 1), which takes
/// the surface from C1 to C2. C1 needs handles at least two rings deep, C2 three: a handle of one ring holds
/// positions only, and one of a single vertex under k_b ends in a rounded peak.
///
/// Departs from the paper: C enters symmetrically, so that A stays positive definite and has a Cholesky
/// factor; soft handles add s_i |d_i - t_i|^2 / 2 with s_i = w / (1 - w) A_ii.
///
///   call            repeat it when ...            cost
///   constructor     rest shape or faces changed   operators, O(n)
///   set_handles()   another set of handles        one factorisation, and with the basis 4 solves per handle
///   set_stiffness() a stiffness changed           numeric factorisation only
///   one of these    some vertices became held,    the part of the factor that depends on these vertices:
///   again           or a painted stiffness        about half of it for a patch; where vertices become free,
///                   changed on some vertices      a whole factorisation
///   set_handles()   another set of handles        with the multigrid a hierarchy of graphs, O(n)
///   solve()         the handles moved             O(n k) with the basis, else one solve for x, y and z; a
///                                                 bind more per substep after the first
///
/// With the multigrid a frame takes 8 to 60 iterations (docs/developer/decisions/multigrid-on-graphs.md), 60 to 100 of
/// which take as long as the factor, and its memory is about 550 bytes per vertex. The shape differs from that of the
/// factor by less than 1e-4 of the motion, and with SolveRequest::start by as much from call to call. It cannot do
/// k_v > 0, nor a painted k_s beside k_b; respond() and the system of a solve need the factor.
///
/// Being linear, it suits translations and gentle bends; details do not rotate with the surface.
class ThinShell final : public SurfaceMethodWith<ThinShellOptions>
{
public:
    /// \throw InvalidOption  a stiffness is negative or not finite, or has neither 1 nor n numbers; or all
    ///   three are zero. set_handles() throws it where the solver is the multigrid, which cannot do them.
    explicit ThinShell(const SurfaceMesh& rest, const ThinShellOptions& options = {});

    /// Changes k_s, k_b and k_v and keeps the handles. Leaves the object as it was if it throws.
    /// \throw InvalidOption  as the constructor.
    /// \throw FactorizationFailed, Cancelled  as set_handles().
    BindReport set_stiffness(const Stiffness& stretching, const Stiffness& bending,
                             const Stiffness& variation, const Progress& progress = {});

    /// The displacements for m columns of constraint values, which are solved together. Call set_handles()
    /// first.
    /// \param constraints  (c, m) one row for each of regions().constraints().
    /// \throw InvalidOption  the multigrid solves.
    LinearResponse respond(const MatrixX& constraints) const;

    /// Null where the options do not ask for it, or where there are more than 16 handles; the next bind frees
    /// it.
    const AffineBasis* affine_basis() const;

    Stepping stepping() const override { return Stepping::anew; }
    bool displaces_all_alike() const override { return true; }

protected:
    std::unique_ptr<SurfaceMethod> made_anew(const SurfaceMesh& rest) const override;
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew
