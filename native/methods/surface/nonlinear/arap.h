// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/surface/method.h"

#include <memory>
#include <string>
#include <vector>

namespace sinew {

struct ArapOptions
{
    /// alpha >= 0 in the energy: how smooth the rotations are. 0 gives the energy of Sorkine and Alexa.
    double smoothness = 5e-4;
    enum class Cells { spokes, rims } cells = Cells::spokes;
    /// How stiff the cells of the vertices are: one number > 0, or one per vertex (painted, >= 0). Painted
    /// values below 1e-3 of the largest one are raised to that, so that the system stays solvable where a
    /// region is painted black.
    std::vector<double> rigidity{1.0};
    /// lambda in [0, 1): how smooth the surface is also where a single vertex is held, instead of a spike. 0
    /// leaves the energy as it is; more is only possible with spokes.
    double point_handles = 0.0;
    int max_iterations = 40; ///< iterations on the mesh per solve, rejected trials included
    /// solve() ends when the relative decrease of the energy is below this twice in succession.
    double tolerance = 1e-4;
};

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
/// possible.
///
/// Departs from the papers: a weight w_ij below 1e-6 of the mean weight (or negative) is raised to
/// that, so no term can be negative, and one above 1e4 of the mean is lowered to that. The start is
/// computed from the poses alone, by a cascade of clustered graphs. The steps are those of L-BFGS in the
/// metric of the Laplacian, with a test of the energy, and corrections by the coarser graphs. Before
/// rotations are fitted to their cells, one linear solve moves all of them together.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   O(n)
///   set_handles()  another set of handles        two factorisations (with point_handles, a third one of
///                                                twice the order), and those of the cascade; the first call
///                                                also computes the weights
///   solve()        the handles moved             as much as 3 to 5 iterations for the start, then its
///                                                iterations: two solves for x, y and z and n rotation fits
///                                                each; every third one is a correction by the coarser
///                                                graphs and costs three times as much
class Arap : public SurfaceMethod
{
public:
    /// \throw InvalidOption  a number is negative or not finite, max_iterations < 1, `rigidity` has neither 1
    ///   nor n numbers or is zero everywhere, or point_handles >= 1, or > 0 with rims.
    explicit Arap(const SurfaceMesh& rest, const ArapOptions& options = {});
    ~Arap() override;
    Arap(Arap&&) noexcept;

    /// E of deformed points, over the parts with a handle and without soft pulls. The rotations are
    /// fitted to the points; with smoothness, until the relative decrease of E is below 1e-9.
    /// \param positions  (n, 3)
    /// \throw InvalidConstraint  there are more or fewer points, or one is not finite.
    double energy(const PointsView& positions) const;

protected:
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    std::vector<std::string> changed_options(const SurfaceMethod& former) const override;
    bool updates(const std::string& option) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace sinew
