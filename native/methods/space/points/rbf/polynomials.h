// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <string>
#include <vector>

namespace sinew {

/// The polynomials beside radial basis functions: all monomials up to a degree, in coordinates along the
/// directions in which some points extend.
///
/// The degree is the highest one, up to that asked for, at which no polynomial vanishes at all points: on
/// points of a plane these are polynomials in the plane, and on a sphere or another quadric they are affine.
class Polynomials
{
public:
    static constexpr int most = 10;

    Polynomials() = default;
    /// \param points  (c, 3) of which at least one.
    /// \param degree  in [-1, 2]; -1 for none.
    Polynomials(const Points& points, int degree);

    int degree() const { return degree_; }
    int count() const { return count_; }
    /// (3) directions in which the points extend: 3 in space, 2 in a plane, 1 on a line, 0 for one place.
    int dimensions() const { return dimensions_; }
    /// \param places       (8, 3) column-major: all x, all y, all z.
    /// \param[out] values  (8, count) column-major
    void evaluate(const double* places, double* values) const;
    /// (n, count)
    RowMatrix evaluate(const Points& points) const;
    /// Which maps of the degree asked for are not carried, and what is used instead; empty if all are.
    std::string remark() const;

private:
    void set_degree(int degree);

    int asked_ = -1, degree_ = -1, count_ = 0, dimensions_ = 3;
    Vector3 centre_ = Vector3::Zero();
    Matrix3 axes_ = Matrix3::Identity(); ///< rows, the first `dimensions_` of which count
};

/// Points that determine the polynomials, as many as these, and at all points the values of the polynomials
/// that are 1 at one of them and 0 at the others.
struct LagrangeBase
{
    LagrangeBase() = default;
    /// \param P  (c, count) of Polynomials::evaluate(), of full rank.
    explicit LagrangeBase(const MatrixX& P);

    std::vector<int> points;
    MatrixX lagrange; ///< (c, count)
    MatrixX inverse;  ///< (count, count) of the rows of P at these points
};

} // namespace sinew
