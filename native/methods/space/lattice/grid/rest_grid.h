// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/methods/space/lattice/grid/axis_basis.h"
#include "native/methods/space/lattice/grid/placed_points.h"

#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace sinew {

struct RestGridOptions
{
    std::array<LatticeBasis, 3> basis{LatticeBasis::bspline, LatticeBasis::bspline, LatticeBasis::bspline};
    int degree = 3;                                  ///< of B-splines, from 1 to 5
    LatticeOutside outside = LatticeOutside::follow; ///< of Bezier and B-spline lattices
    int continuity = 1; ///< k of LatticeOutside::freeze: k + 1 planes of points stay beside each border
    /// Columns: the direction of each axis that has one point only, along which nothing changes; by default
    /// across the other axes.
    std::optional<Matrix3> axes{};

    bool operator==(const RestGridOptions&) const = default;
};

/// A lattice of control points in rows, columns and layers, at rest: where points lie in it.
///
/// A lattice whose cells are all the same parallelepiped has a closed form along each axis. In any other, the
/// parameters (u, v, w) of a point x solve sum_ijk B_i(u) B_j(v) B_k(w) p_ijk = x, by Newton's method with
/// steps that are shortened until the error falls [Coquillart 1990]. Where no parameters are found, the point
/// takes the nearest ones. For Blender's functions, the parameters are those of straight lines between the
/// points, as Blender computes them for lattices of equal cells.
class RestGrid
{
public:
    /// \param points      (c, 3), the first index first: i + u (j + v k).
    /// \param resolution  (u, v, w) with u v w = c.
    /// \throw InvalidMesh    a point is not finite, or the lattice is flat or folded; points are named.
    /// \throw InvalidOption  the resolution does not fit the points, or as AxisBasis; or all points stay.
    RestGrid(const PointsView& points, const std::array<int, 3>& resolution, const RestGridOptions& options);

    int point_count() const { return static_cast<int>(points_.rows()); }
    const Points& points() const { return points_; }
    int cell_count() const { return axes_[0].pieces() * axes_[1].pieces() * axes_[2].pieces(); }
    /// Longest side of the box around the points.
    double size() const { return size_; }

    LatticePlace place(const Vector3& point) const;
    /// The part of a lattice with these moves that acts on a cell.
    /// \param moves  (c, 3), row-major, which must live as long as the result.
    BlendCell cell(int index, const double* moves) const;
    /// (c, 3) how far the points of a posed lattice have moved; 0 for those that stay.
    void moves(PointsView posed, Points& moves) const;
    /// The functions of all points at a place, (c); 0 for those that stay.
    VectorX weights(const LatticePlace& place) const;

    bool operator==(const RestGrid& other) const
    {
        return resolution_ == other.resolution_ && options_ == other.options_ && points_ == other.points_;
    }

private:
    Vector3 corner(int i, int j, int k) const
    {
        return points_.row(i + resolution_[0] * (j + resolution_[1] * k)).transpose();
    }
    void find_frame();
    void refuse_folds() const;
    void find_frozen();
    Vector3 mapped(const Vector3& parameter, Matrix3& jacobian) const;
    Vector3 parameters_of(const Vector3& point) const;

    Points points_;
    std::array<int, 3> resolution_;
    RestGridOptions options_;
    std::vector<AxisBasis> axes_; ///< (3)
    std::vector<AxisBasis> map_; ///< (3) the functions of the map that places points in the rest lattice
    double size_ = 0.0;
    bool is_affine_ = false;
    Vector3 origin_;
    Matrix3 frame_, inverse_; ///< columns: from point to point along each axis
    std::vector<char> frozen_;
};

} // namespace sinew
