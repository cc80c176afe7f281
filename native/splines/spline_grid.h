// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/splines/bspline_basis.h"
#include "native/splines/control_fit.h"

#include <array>
#include <vector>

namespace sinew {

/// A grid of control points over the unit square, and the tensor-product spline that they steer:
///
///     f(u, v) = sum_ij c_ij N_i(u) N_j(v).
///
/// Point i of row j has the index j * columns + i. Knots are uniform, so the grid goes beyond the square by
/// (degree - 1) / 2 spans on each side, and its points are evenly spaced.
class SplineGrid
{
public:
    /// \throw InvalidOption  see BsplineBasis.
    SplineGrid(int degree, int columns, int rows) : u_(degree, columns), v_(degree, rows) {}

    int degree() const { return u_.degree(); }
    int columns() const { return u_.count(); }
    int rows() const { return v_.count(); }
    int size() const { return columns() * rows(); }
    const BsplineBasis& along_u() const { return u_; }
    const BsplineBasis& along_v() const { return v_; }

    /// What f needs of one place: the first control point, and the functions along u and v.
    struct Stencil
    {
        int first;
        std::array<double, most_spline_degree + 1> u, v;
    };
    /// \param u, v  moved into [0, 1] if they lie outside.
    Stencil stencil(double u, double v) const;

    /// f at a stencil.
    /// \param control  (size, m)
    /// \param[out] value  (m)
    void evaluate(const Stencil& stencil, const RowMatrix& control, double* value) const;

    /// (number of stencils, size) the weights of the control points at places.
    WeightRows weights(const std::vector<Stencil>& stencils) const;

    /// (size, size) the quadratic form of the sum of squares of all second differences of the control points,
    /// with those across counted twice, as in the energy of a thin plate. It is zero for functions that are
    /// linear in u and v.
    MatrixX bending() const;

private:
    BsplineBasis u_, v_;
};

} // namespace sinew
