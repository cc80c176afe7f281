// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace sinew {

/// How the control points along one axis of a lattice blend.
enum class LatticeBasis {
    bezier,        ///< Bernstein polynomials: one piece, of a degree one below the number of points
    bspline,       ///< B-splines of a degree from 1 to 5 that end at the first and the last point
    linear,        ///< as Blender's lattices: straight lines from point to point
    cardinal,      ///< likewise: cubics through the points, steeper than straight lines by 0.42
    catmull_rom,   ///< likewise: cubics through the points
    blender_spline ///< likewise: cubic B-splines that repeat the first and the last point
};

/// What a lattice does beyond its borders. Blender's functions are constant there, some cells away.
enum class LatticeOutside {
    follow, ///< each function goes on as a straight line, so affine maps are reproduced everywhere
    freeze  ///< some planes of points beside each border stay at rest, and so does everything outside
};

/// The functions of the control points along one axis. They sum to 1 everywhere, and are piecewise
/// polynomials of the parameter s.
///
/// T. W. Sederberg, S. R. Parry. "Free-Form Deformation of Solid Geometric Models." SIGGRAPH 1986.
/// S. Coquillart. "Extended Free-Form Deformation." SIGGRAPH 1990. Tutorial, section 5.1.
///
/// Point i of n is at the place i. Blender's functions take the place itself as their parameter; those of
/// Bezier and B-spline lattices take s in [0, spans], for which sum_i B_i(s) i is the place, so that they
/// reproduce straight lines.
class AxisBasis
{
public:
    static constexpr int most_bezier_points = 16; ///< beyond, rounding errors grow to 1e-11

    /// \param points  n >= 1; B-splines of fewer than degree + 1 points have the degree n - 1.
    /// \throw InvalidOption  the degree is not between 1 and 5, or a Bezier lattice has too many points.
    AxisBasis(LatticeBasis basis, int points, int degree, LatticeOutside outside);

    int points() const { return points_; }
    int width() const { return width_; }   ///< how many functions may differ from 0 at a place
    int degree() const { return degree_; } ///< of the polynomials
    int pieces() const { return static_cast<int>(pieces_.size()); }
    /// Whether the functions reproduce straight lines.
    bool is_linear_precise() const { return own_parameter_; }
    /// Whether the place itself is the parameter.
    bool is_place() const { return !own_parameter_; }

    /// The piece of a parameter; `local` is where it lies in the piece.
    int piece(double s, double& local) const;
    /// Index of the first of the width() points of a piece.
    int first(int piece) const { return pieces_[piece].first; }
    /// (width, degree + 1) coefficients of the functions in a piece, by powers of the local parameter.
    const double* coefficients(int piece) const
    {
        return coefficients_.data() + static_cast<std::size_t>(piece) * width_ * (degree_ + 1);
    }

    /// The functions at a parameter, and their derivatives if wanted.
    /// \param[out] values  (width)
    /// \return the index of the first point.
    int values(double s, double* values, double* derivatives = nullptr) const;
    /// The parameter of a place.
    double parameter(double place) const;
    /// The place of a parameter.
    double place(double s, double* derivative = nullptr) const;
    /// Whether a parameter lies beyond the first or the last point.
    bool is_outside(double s) const { return s < -tolerance || s > end_ + tolerance; }
    double end() const { return end_; } ///< the parameter of the last point

    bool operator==(const AxisBasis& other) const
    {
        return points_ == other.points_ && coefficients_ == other.coefficients_ && end_ == other.end_;
    }

private:
    static constexpr double tolerance = 1e-9;
    struct Piece
    {
        int first;
        double origin; ///< the parameter at which the local one is 0
    };
    void add_spans(int degree, LatticeOutside outside);
    void add_cells(LatticeBasis basis);

    int points_, width_ = 1, degree_ = 0;
    bool own_parameter_ = false;
    double end_ = 0.0, begin_ = 0.0; ///< begin_: where the second piece begins; the others are 1 long
    std::vector<Piece> pieces_;
    std::vector<double> coefficients_;
};

} // namespace sinew
