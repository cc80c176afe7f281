// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/lattice/grid/hexahedra.h"
#include "native/methods/space/lattice/grid/rest_grid.h"
#include "native/methods/space/method.h"

#include <variant>

namespace sinew {

/// Free-form deformation by a lattice of control points.
///
/// T. W. Sederberg, S. R. Parry. "Free-Form Deformation of Solid Geometric Models." SIGGRAPH 1986.
/// S. Coquillart. "Extended Free-Form Deformation: A Sculpturing Tool for 3D Geometric Modeling." SIGGRAPH
/// 1990. R. MacCracken, K. I. Joy. "Free-Form Deformations With Lattices of Arbitrary Topology." SIGGRAPH
/// 1996. Tutorial, section 5.1.
///
///     x' = x + sum_ijk B_i(u) B_j(v) B_k(w) (p'_ijk - p_ijk)
///
/// with (u, v, w) where the rest lattice p has x. The functions are those of AxisBasis: Bernstein
/// polynomials, B-splines of degrees 1 to 5, or the four of Blender's lattices, which give the numbers of
/// Blender's Lattice modifier as long as the lattice at rest has equal cells. A RestGrid has rows, columns
/// and layers; Hexahedra have any topology, such as a cylinder or boxes that fit an object.
///
/// Where the functions reproduce straight lines (Bezier, B-splines, and hexahedra), an affine map of the
/// lattice is the same map of the points. Blender's functions reproduce translations.
///
/// LatticeOutside::freeze holds k + 1 planes of points beside each border, so that the deformation ends there
/// with k continuous derivatives, and all points outside stay.
///
///   call          repeat it when ...            cost
///   constructor   the rest lattice changed      O(lattice)
///   bind()        the points changed            O(points) for equal cells, else some Newton steps per point
///   warp()        the lattice moved             O(points x functions): 64 functions for cubics, or 8
///
/// Memory of a bind: up to 35 bytes per point, and 24 for the point itself; 120 more while it runs.
class Ffd : public SpaceMethodWith<PlacedPoints>
{
public:
    explicit Ffd(RestGrid lattice);
    explicit Ffd(Hexahedra lattice);

    int control_count() const;

protected:
    void compute(PointsView points, SpaceReport& report, const Progress& progress) override;
    void displace(PointsView control, PointsView base, PositionsOut out) const override;
    /// "lattice", which includes its options.
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;

private:
    std::variant<RestGrid, Hexahedra> lattice_;
};

} // namespace sinew
