// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/surface/method.h"

#include <memory>
#include <string>
#include <vector>

namespace sinew {

struct ArapOptions
{
    /// alpha >= 0 of the smooth rotations [LG15]; 0 is the textbook energy of [SA07].
    double smoothness = 5e-4;
    enum class Cells { spokes, rims } cells = Cells::spokes;
    /// One number > 0, or one a vertex (painted, >= 0): how stiff its cell is. Painted values
    /// below 1e-3 of their largest are raised to it, so that a region painted black stays solvable.
    std::vector<double> rigidity{1.0};
    int max_iterations = 40; ///< fine iterations a solve, rejected trials included
    /// solve() ends after two relative decreases of the energy in a row below this.
    double tolerance = 1e-5;
};

/// As-rigid-as-possible surface deformation with smooth rotations.
///
/// O. Sorkine, M. Alexa. "As-Rigid-As-Possible Surface Modeling." SGP 2007.
/// Z. Levi, C. Gotsman. "Smooth Rotation Enhanced As-Rigid-As-Possible Mesh Animation."
/// IEEE TVCG 21(2), 2015.
///
/// With base points p (rest, or the incoming pose), deformed points q, and one rotation R_i a
/// vertex, over ordered pairs of neighbours,
///
///     E = sum_i r_i sum_j w_ij |(q_i - q_j) - R_i (p_i - p_j)|^2
///       + alpha A sum_ij r_ij w_ij |R_i - R_j|^2
///
/// w_ij is the cotan weight of operators/laplacian.h, A the rest area, r painted rigidity and
/// r_ij its mean over the edge. `rims` adds the edges opposite each vertex to its cell. Without
/// the second term bending stiffness falls with the square of the edge length: dense meshes
/// buckle like foil, and no two starts end in the same shape.
///
/// Departs from the papers: w_ij below 1e-6 of the mean weight (negative ones too) is raised to
/// it, so no term can be negative, and above 1e4 of the mean lowered to it; the start comes from
/// the poses alone by a cascade of clustered graphs; steps are L-BFGS in the Laplacian metric
/// with an energy test; all rotations move together by one linear solve before the fit.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   O(n)
///   set_handles()  another set of handles        two factorisations, the cascade's, once weights
///   solve()        the handles moved             some 5-9 iterations' worth for the start, then an
///                                                iteration: two solves of x, y, z and n rotation fits
class Arap final : public SurfaceMethod
{
public:
    /// \throw InvalidOption  a number negative or not finite, max_iterations < 1, or rigidity of
    ///                       a length other than 1 or n, or zero everywhere.
    explicit Arap(const SurfaceMesh& rest, const ArapOptions& options = {});
    ~Arap() override;
    Arap(Arap&&) noexcept;

    /// E of given (n, 3) points over the parts that have a handle, without soft pulls, the
    /// rotations fitted to the points (with smoothness: settled, to 1e-9 of E).
    /// \throw InvalidConstraint  another number of points, or one not finite.
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
