// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/methods/surface/method.h"

#include <string>
#include <vector>

namespace sinew {

struct PrimoOptions
{
    std::vector<double> height{0.05};
    int max_iterations = 40;
    double tolerance = 1e-4;

    static constexpr auto table()
    {
        using O = PrimoOptions;
        return std::tuple{
            painted_option(
                "height", &O::height, Rebind::anew, at_least(0),
                "how far the prisms reach above and below the surface, as a share of the size of their "
                "part (SurfaceMesh.sizes); values below 1e-3 of the largest one are raised to that. "
                "Higher prisms resist bending and twisting more"),
            iteration_limit(&O::max_iterations), stopping_tolerance(&O::tolerance)};
    }
};

/// Surface deformation by rigid prisms that an elastic joint couples at every edge.
///
/// M. Botsch, M. Pauly, M. Gross, L. Kobbelt. "PriMo: Coupled Prisms for Intuitive Surface Modeling."
/// SGP 2006.
///
/// Each face is the middle of a prism, whose corners lie at v +- h n_v, with the unit normal n_v at rest. At
/// rest, prisms that share an edge e also share a side, on which a point has the coordinates (s, t) in [0,
/// 1]^2. Prisms only move rigidly, so that the two copies of the side come apart by d(s, t), which is
/// bilinear. The energy is
///
///     E = sum over such pairs  |e|^2 / (A_i + A_j)  int_0^1 int_0^1 |d(s, t)|^2 ds dt
///
/// where the integral is (1/9) sum d_ij . d_kl 2^(-|i-k|-|j-l|) over the corners of the side. As the four
/// products m, a (2 s - 1), b (2 t - 1), c (2 s - 1) (2 t - 1) of the mean gap, its changes along the two
/// directions and its skew part are orthogonal, it is also |m|^2 + |a|^2 / 3 + |b|^2 / 3 + |c|^2 / 9; with
/// m = t_i + R_i p - t_j - R_j q, and a, b and c of the form (R_i - R_j) u, that is the energy of
/// RigidBodies. A vertex goes to the mean of where the prisms around it take it.
///
/// Departs from the paper: a face of any number of corners is one prism. A handle may hold any vertices, not
/// only faces: a prism whose corners are all held follows them, also where the poses are not rigid, and one
/// that has some held corners is joined to these by 10 times the median weight. Instead of shape matching for
/// single prisms on a hierarchy and Newton steps for all, centres and rotations move together by L-BFGS with
/// two constant factors, from the answer of coarser as-rigid-as-possible graphs, which depends on the poses
/// alone. Small areas are raised, and weights stay within 1e-6 to 1e4 of their median.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   O(n)
///   set_handles()  another set of handles        two factorisations, and those of the coarser graphs
///   solve()        the handles moved             as much as 3 iterations for the start, then its iterations:
///                                                three solves for x, y and z and two fits per face each
class Primo final : public SurfaceMethodWith<PrimoOptions>
{
public:
    /// \throw InvalidOption  a number is negative or not finite, max_iterations < 1, or `height` has neither
    ///   1 nor n numbers or is zero everywhere.
    explicit Primo(const SurfaceMesh& rest, const PrimoOptions& options = {});

protected:
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    /// The energy of the report is that of the prisms and of soft pulls.
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew
