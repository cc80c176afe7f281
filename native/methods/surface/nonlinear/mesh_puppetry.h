// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/methods/surface/method.h"

#include <string>
#include <vector>

namespace sinew {

struct MeshPuppetryOptions
{
    double bending = 1e-3;
    int max_iterations = 20;
    double tolerance = 1e-4;

    static constexpr auto table()
    {
        using O = MeshPuppetryOptions;
        return std::tuple{option("bending", &O::bending, Rebind::anew, at_least(0),
                                 "lambda: how much bends and bumps are kept, beside the lengths of edges"),
                          iteration_limit(&O::max_iterations), stopping_tolerance(&O::tolerance)};
    }
};

/// The skin of a puppet: handles are the rigid middles of its limbs, and the surface between two limbs
/// follows both.
///
/// X. Shi, K. Zhou, Y. Tong, M. Desbrun, H. Bao, B. Guo. "Mesh Puppetry: Cascading Optimization of Mesh
/// Deformation with Inverse Kinematics." SIGGRAPH 2007.
///
/// With base points p (the incoming shape, or the rest shape), deformed points q, and one rotation R_i per
/// vertex, which is that of the limb at its vertices,
///
///     E = 1/2 sum_i [ sum_j w_ij |(q_i - q_j) - R_i (p_i - p_j)|^2
///                     + lambda A / m_i |(L q)_i - R_i (L p)_i|^2 ]
///
/// w_ij, L and m_i are the weights, the Laplacian and the masses of operators/laplacian.h, A the rest area.
///
/// Departs from the paper: where the skeleton goes is solved first (native/skeleton/pose_solver.h), and the
/// skin follows, so that a frame depends on the poses of the bones alone, whoever posed them. The paper's
/// volume term is left out. The rotations start as blends of those of the limbs, by harmonic fields along the
/// surface, and one linear solve gives the start of a few steps of L-BFGS. A weight w_ij below 1e-6 of the
/// mean weight (or negative) is raised to that, and one above 1e3 of the mean is lowered to that.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   O(n)
///   set_handles()  another set of handles        two factorisations and one solve per handle
///   solve()        the handles moved             two solves for x, y and z, and one more with n rotation
///                                                fits per iteration
class MeshPuppetry final : public SurfaceMethodWith<MeshPuppetryOptions>
{
public:
    /// \throw InvalidOption  a number is negative or not finite, or max_iterations < 1.
    explicit MeshPuppetry(const SurfaceMesh& rest, const MeshPuppetryOptions& options = {});

protected:
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew
