// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/methods/surface/method.h"

#include <string>
#include <vector>

namespace sinew {

struct ThinShellNonlinearOptions
{
    enum class Measure { share, length, stiffness } measure = Measure::share;
    std::vector<double> thickness{0.02};
    std::vector<double> stretching{1.0};
    std::vector<double> bending{1.0};
    int max_iterations = 60;
    double tolerance = 1e-4;

    static constexpr auto table()
    {
        using O = ThinShellNonlinearOptions;
        return std::tuple{
            option("measure", &O::measure, Rebind::anew,
                   "'share': thickness is a share of the size of its part (SurfaceMesh.sizes); 'length': a "
                   "length; 'stiffness': stretching and bending count instead"),
            painted_option("thickness", &O::thickness, Rebind::anew, at_least(0),
                           "k_s is 1 and k_b the square of the thickness"),
            painted_option(
                "stretching", &O::stretching, Rebind::anew, at_least(0),
                "k_s; values below 1e-3 of the largest one are raised to that, so that the system stays "
                "solvable where a region is painted black"),
            painted_option("bending", &O::bending, Rebind::anew, at_least(0),
                           "k_b: an area times the unit of k_s"),
            iteration_limit(&O::max_iterations),
            stopping_tolerance(&O::tolerance)};
    }
};
constexpr auto choices(ThinShellNonlinearOptions::Measure)
{
    using Measure = ThinShellNonlinearOptions::Measure;
    return std::array{Choice{"share", Measure::share}, Choice{"length", Measure::length},
                      Choice{"stiffness", Measure::stiffness}};
}

/// Nonlinear thin shell: a sheet that resists stretching, and bending away from its rest curvature.
///
/// D. Terzopoulos, J. Platt, A. Barr, K. Fleischer. "Elastically Deformable Models." SIGGRAPH 1987. Tutorial,
/// section 4.3, Eq. 9: the integral of k_s |I' - I|^2 + k_b |II' - II|^2, with the first and second
/// fundamental forms before and after.
///
/// Two triangles T that share an edge e are a cell h with a rotation R_h. With base points p (the incoming
/// shape, or the rest shape), deformed points q, and areas A_T that sum to A_h over a cell,
///
///     E = 1/2 sum_h [ k_s sum_T A_T / c_T |grad_T q - R_h grad_T p|^2 + k'_h / A_h |K_h q - R_h K_h p|^2 ]
///
/// where c_T is the number of cells that contain T, and
///
///     K_h q = (b1 + b2) q_0 + (a1 + a2) q_1 - (a1 + b1) q_2 - (a2 + b2) q_3
///
/// with the cotangents a at q_0 and b at q_1 of both triangles at the edge (0, 1) whose opposite corners are
/// 2 and 3. Where lengths are kept, K_h q has the length 2 |e| sin(theta / 2) for the angle theta between the
/// triangles, so the second term is k_b |e|^2 / A_h (theta' - theta)^2 for small changes. Then k_b has the
/// same meaning as in methods/surface/linear/thin_shell.h: a sheet that is rolled up costs what a plate
/// costs.
///
/// Departs from the paper: each cell compares vectors after it has turned, and no angles; energies with
/// angles have minima where different starts get stuck. A cell that turns as one resists folding by itself,
/// as much as a sheet with k_b = k_s A_h^2 / (4 |e|^2) mean(1 / c_T) does. That is taken off: k'_h = k_b less
/// that share, and at least 0. Where it is 0, the sheet is thinner than the mesh can show, about a quarter of
/// an edge, and stiffer than asked for; the bind report names such vertices. At a triangle with (nearly) no
/// area k'_h is 0, too. At an edge of more than two triangles, each of them is paired with the next.
///
/// The Hessian in q for fixed rotations is constant. solve() starts with the rotations of the cascade of ARAP
/// (local_global/arap/coarse_start.h), smoothed as much as the sheet is stiff, and then takes steps of L-BFGS
/// in the metric of that matrix, with a test of the energy.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   O(n)
///   set_handles()  another set of handles        one factorisation with twice the entries of that of ARAP,
///                                                and those of the cascade
///   solve()        the handles moved             as much as 2 to 4 iterations of ARAP for the start, then
///                                                its iterations: one solve for x, y and z and 3 n rotation
///                                                fits each
class ThinShellNonlinear final : public SurfaceMethodWith<ThinShellNonlinearOptions>
{
public:
    /// \throw InvalidOption  a number is negative or not finite, max_iterations < 1, an option has neither 1
    ///   nor n numbers, or `stretching` is zero everywhere.
    explicit ThinShellNonlinear(const SurfaceMesh& rest, const ThinShellNonlinearOptions& options = {});

    /// E of deformed points, over the parts with a handle and without soft pulls, with the best rotations.
    /// Zero before set_handles().
    /// \param positions  (n, 3)
    /// \throw InvalidConstraint  there are more or fewer points, or one is not finite.
    double energy(const PointsView& positions) const;

protected:
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew
