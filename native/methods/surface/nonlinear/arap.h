// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/handles/system_solver.h"
#include "native/methods/surface/method.h"

#include <string>
#include <vector>

namespace sinew {

struct ArapOptions
{
    double smoothness = 5e-4;
    enum class Cells { spokes, rims } cells = Cells::spokes;
    std::vector<double> rigidity{1.0};
    double point_handles = 0.0;
    int max_iterations = 40;
    double tolerance = 1e-3;
    SystemSolver solver = SystemSolver::automatic;

    static constexpr auto table()
    {
        using O = ArapOptions;
        return std::tuple{
            option("smoothness", &O::smoothness, Rebind::anew, at_least(0),
                   "alpha: how smooth the rotations are; 0 gives the energy of Sorkine and Alexa, which "
                   "buckles on dense meshes"),
            option("cells", &O::cells, Rebind::anew, "'spokes' [SA07] or 'rims' (spokes and rims)"),
            painted_option(
                "rigidity", &O::rigidity, Rebind::anew, at_least(0),
                "how stiff each vertex's cell is; values below 1e-3 of the largest one are raised to "
                "that, so that the system stays solvable where a region is painted black"),
            iteration_limit(&O::max_iterations),
            stopping_tolerance(
                &O::tolerance,
                "a solve stops when, by the ways of its last two iterations, no point has more "
                "than this share of the size of the rest shape left to go"),
            option("point_handles", &O::point_handles, Rebind::anew, from_to_below(0, 1),
                   "lambda: how smooth the surface is also at handles of a single vertex, instead of a "
                   "spike [Oehri, Herholz & Sorkine-Hornung 2025]; with 'spokes' only. The energy of a "
                   "report is then (1 - lambda) E + 2 lambda sum |r_i|^2 / m_i with r the gradient of E / "
                   "4 at all vertices and masses m whose mean is 1"),
            solver_option(&O::solver)};
    }
};
constexpr auto choices(ArapOptions::Cells)
{
    return std::array{Choice{"spokes", ArapOptions::Cells::spokes}, Choice{"rims", ArapOptions::Cells::rims}};
}

/// As-rigid-as-possible surface deformation with smooth rotations.
///
/// O. Sorkine, M. Alexa. "As-Rigid-As-Possible Surface Modeling." SGP 2007.
/// Z. Levi, C. Gotsman. "Smooth Rotation Enhanced As-Rigid-As-Possible Mesh Animation."
/// IEEE TVCG 21(2), 2015.
/// A. Oehri, P. Herholz, O. Sorkine-Hornung. "Higher Order Continuity for Smooth As-Rigid-As-Possible Shape
/// Modeling." 2025.
///
/// With base points p (the incoming shape, or the rest shape), deformed points q, and one rotation R_i per
/// vertex, the energy over ordered pairs of neighbours is
///
///     E = sum_i r_i sum_j w_ij |(q_i - q_j) - R_i (p_i - p_j)|^2
///       + alpha A sum_ij r_ij w_ij |R_i - R_j|^2
///
/// w_ij is the cotan weight of operators/laplacian.h, A the rest area, r the painted rigidity and
/// r_ij its mean over the edge. `rims` adds the edges opposite each vertex to its cell. Without
/// the second term, bending stiffness falls with the square of the edge length: dense meshes
/// buckle like foil, and different starts end in different shapes.
///
/// With `point_handles`, the positions for given rotations minimise the energy of HigherOrder instead, four
/// times which is the energy of a report: (1 - lambda) E + 2 lambda sum |r_i|^2 / m_i, r = dE / dq / 4. Each
/// step then asks that this energy falls, though the rotations are those of E, so that an early end is
/// possible. A tenth of the tolerance counts there and on meshes too small for
/// clusters, a fifth below 10,000 vertices.
///
/// Departs from the papers: a weight w_ij below 1e-6 of the mean weight (or negative) is raised to
/// that, so no term can be negative, and one above 1e4 of the mean is lowered to that. The start is
/// computed from the poses alone, by a cascade of clustered graphs. The steps are those of L-BFGS in the
/// metric of the Laplacian, with a test of the energy, each followed by a motion of clusters. Before
/// rotations are fitted to their cells, one linear solve moves all of them together. The last step goes on by
/// what steps that shrink steadily leave, unless the energy would rise above that before the step.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   O(n)
///   set_handles()  another set of handles        two factorisations (with point_handles, a third one of
///                                                twice the order), and those of the cascade; the first call
///                                                also computes the weights
///   set_handles()  another set of handles        with the multigrid half of that: the factors of the cascade
///   solve()        the handles moved             as much as two or three iterations for the start, then its
///                                                iterations: two solves for x, y and z, n rotation fits and
///                                                a motion of clusters each
///
/// With the multigrid each of these solves takes 1 to 4 cycles between the mesh and the first level of the cascade
/// (GraphIteration), so a frame takes some three times as long. Its shape differs from that of the factor by less than
/// 1e-4 of the size. It cannot do point_handles > 0.
class Arap : public SurfaceMethodWith<ArapOptions>
{
public:
    /// \throw InvalidOption  a number is negative or not finite, max_iterations < 1, `rigidity` has neither 1
    ///   nor n numbers or is zero everywhere, or point_handles >= 1, or > 0 with rims.
    explicit Arap(const SurfaceMesh& rest, const ArapOptions& options = {});

    /// E of deformed points, over the parts with a handle and without soft pulls. The rotations are
    /// fitted to the points; with smoothness, until the relative decrease of E is below 1e-9.
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
