// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <array>
#include <vector>

namespace sinew {

/// How a surface bends at each vertex (section 3.1 of the tutorial), in units of 1 / length, K of 1 / area.
///
/// The sign: where faces look outward, convex places have positive curvatures, and a sphere of radius r has
/// H = 1 / r. So the second form is minus Eq. 2, as in Delta x = -2 H n, which the tutorial states as well.
///
///   mean        H = n . (L x) / (2 m), with L and m of operators/laplacian.h, cotan_voronoi  [MDSB03, Eq. 8]
///   gaussian    K = (2 pi - sum of the angles at the vertex) / m                             [MDSB03, Eq. 9]
///   principal   of a cubic height field over the tangent plane, fitted to the rings around the vertex by
///               least squares: F. Cazals, M. Pouget. "Estimating Differential Quantities Using Polynomial
///               Fitting of Osculating Jets." Computer Aided Geometric Design 22(2), 2005, sections 3 and 4.
///
/// H and K sum exactly: the sum of m K is 2 pi times the Euler characteristic of a closed surface. One by one,
/// they converge only where the faces are regular. The fit's errors fall with the square of the edge length
/// on every sequence of finer meshes that stay in shape, so H and K are taken from it at the border, where
/// angles and Laplacian say how the border bends instead, and where an edge has more than two triangles.
///
/// A face of more than 200 corners does not count for the fit, nor do, but for itself, the faces of a vertex with
/// more than 200.
///
/// A vertex in no face has curvature 0, and so have those whose neighbours are all on a line.
struct Curvature
{
    VectorX mean, gaussian;
    Points normals; ///< (n, 3) of the fit, unit, to the side that the faces look to; 0 for loose vertices
    /// (n) the smallest and the largest normal curvature.
    std::array<VectorX, 2> principal;
    /// (n, 3) unit tangents along which these are, a right-handed frame with the normal. The sign of the first
    /// is chosen by the axes: of its coordinates, the first that is clearly the largest one is positive.
    std::array<Points, 2> directions;
    /// (n, 3) x_u and x_v, with u and v along two axes of the plane of the fit.
    std::array<Points, 2> tangents;
    /// (n) x_u x_u, x_u x_v, x_v x_v: the first fundamental form, Eq. 1.
    std::array<VectorX, 3> first_form;
    /// (n) its second derivatives along minus the normal: the second fundamental form.
    std::array<VectorX, 3> second_form;

    /// (n) the normal curvature along directions, t II t / t I t. Only what is tangential of them counts; NaN
    /// never: 0 where nothing is left.
    /// \param directions  (n, 3), of any length; those of another vertex are not looked at.
    VectorX along(const PointsView& directions) const;
};

/// Cost: O(n), about as much as a factor of a small Laplacian: a least-squares fit of 9 unknowns per vertex.
///
/// \param rings  of neighbours that are fitted, >= 1. More rings smooth noise, and blur what is smaller. Where
///   they hold less than 15 neighbours, as at a border, further rings are added; where the part has no more,
///   the field is of the degree that these determine.
/// \throw InvalidOption  rings < 1.
Curvature curvature(const SurfaceMesh& mesh, int rings = 2);

} // namespace sinew
