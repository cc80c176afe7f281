// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/methods/surface/method.h"

#include <string>
#include <vector>

namespace sinew {

struct SplineSurfaceOptions
{
    int degree = 3;
    int columns = 8;
    int rows = 8;
    double smoothing = 1e-3;
    double margin = 0.2;
    RowMatrix uv_map{}; ///< empty for None

    static constexpr auto table()
    {
        using O = SplineSurfaceOptions;
        return std::tuple{
            option("degree", &O::degree, Rebind::update, between(1, 5), "of the spline"),
            option("columns", &O::columns, Rebind::update, between(2, 32),
                   "control points of the grid of each part along u; fewer than degree + 1 count as that"),
            option("rows", &O::rows, Rebind::update, between(2, 32), "the same along v"),
            option("smoothing", &O::smoothing, Rebind::update, at_least(0),
                   "how much the grid resists being bent; 0 for least squares, and the least norm, alone"),
            option("margin", &O::margin, Rebind::update, at_least(0),
                   "how far the grid reaches into the handles, as a share of twice the distance of the "
                   "farthest free vertex of a part from their mean; one ring of held vertices is always "
                   "within it"),
            option("uv_map", &O::uv_map, Rebind::update,
                   "(n, 2) u and v of each vertex, NaN where it has none; None for the plane of least "
                   "squares of each part")};
    }
};

/// Spline surface: a tensor-product B-spline displaces the surface, and the handles move its control grid.
///
/// G. Farin. "Curves and Surfaces for Computer Aided Geometric Design." Academic Press, 1997.
/// Tutorial, sections 2.1 and 4.1.
///
///     d(u, v) = sum_ij c_ij N_i(u) N_j(v)
///
/// with the uniform B-splines of splines/bspline_basis.h, and (u, v) of a vertex from a UV map or from the
/// plane of least squares, oriented by the principal axes or, where these are open, from the first handle to
/// the last one. Each part of the surface has a grid of its own. Its rectangle bounds its region: the free
/// vertices, and those held ones that the margin reaches along the surface. The vertices of handles in the
/// region are point constraints d(u_i, v_i) = d_i. The grid meets them in the sense of least squares, each
/// handle counting by the mean of its weights, and where they leave it open, the control points move by as
/// little as possible beside the mean motion (splines/control_fit.h).
///
/// Departs from the paper in three ways. With `smoothing` 0 the grid is the one of the paper, up to the mean
/// motion, without which a handle that is moved with all others would leave behind the control points that no
/// handle touches. Least squares follow every bump in the data, and a control point at the edge of the data
/// may fly off. So by default, second differences of the grid cost energy, which also makes fair what the
/// data leave open.
///
/// SolveRequest::grid moves control points further. Each moves the rectangle of its degree + 1 spans in both
/// directions, and held vertices stay where the handles hold them.
///
/// A spline of few control points does not meet all vertices of a handle. Held vertices are met exactly all
/// the same: what the spline misses there is spread over the free surface by a harmonic field (Eq. 8 with
/// positive weights), so that no step shows at the border of a region. Soft handles pull at the spline with
/// their weights, and then at that field. The report's energy is the Dirichlet energy of this field, and its
/// residual how much the spline of the handles missed: the root of sum W |B c - d|^2 / sum W |d|^2.
///
///   call             repeat it when ...            cost
///   constructor      rest shape or faces changed   nothing
///   set_handles()    another set of handles        one factorisation of a Laplacian, for k control points
///                                                  O(k^3), and for the basis of up to 16 handles 4 solves
///                                                  each
///   solve()          the handles moved             O(n) per handle with the basis; else, or if control
///                                                  points are moved, O(n + k^2) and one solve for x, y, z
///   control_grids()  the grid is shown             O(n + k^2)
///
/// Being linear, it suits translations and gentle bends of sheets; the rectangular grid shows in the result,
/// and across the seams of a UV map the surface does not hold together.
class SplineSurface final : public SurfaceMethodWith<SplineSurfaceOptions>
{
public:
    /// \throw InvalidOption  an option is out of range; or `uv_map` has another number of rows than the mesh
    ///   has vertices, not two columns, or an infinite number.
    explicit SplineSurface(const SurfaceMesh& rest, const SplineSurfaceOptions& options = {});

    bool displaces_all_alike() const override { return true; }

    /// The grid of a part, as the handles move it.
    struct Grid
    {
        int columns, rows;
        Points points; ///< (columns * rows, 3) row by row
    };
    /// One grid per part with a free vertex and a handle, in the order of the parts. At rest, the spline of a
    /// grid fits the surface. SolveRequest::grid has a row for each of their points, grid after grid.
    /// \throw InvalidConstraint  as solve().
    std::vector<Grid> control_grids(const SolveRequest& request) const;

protected:
    /// \throw InvalidOption  vertices that a grid covers have no place on the UV map; the elements of the
    ///   error are these vertices.
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew
