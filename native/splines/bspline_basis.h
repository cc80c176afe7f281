// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

namespace sinew {

constexpr int most_spline_degree = 5;

/// The B-spline functions N_i of one degree on [0, 1].
///
/// G. Farin. "Curves and Surfaces for Computer Aided Geometric Design." Academic Press, 1997. Evaluated by
/// the recurrence of de Boor and Cox.
///
/// With p the degree and m functions, [0, 1] is divided into m - p spans of equal length, on each of which
/// p + 1 functions are not zero. The functions are polynomials on each span, join with p - 1 continuous
/// derivatives, are never negative, and sum to 1.
class BsplineBasis
{
public:
    /// What the knots do beyond 0 and 1.
    enum class Ends {
        uniform, ///< they go on at the same distance: all functions are shifted copies of one
        clamped  ///< they pile up at 0 and 1: the first and the last function are 1 there
    };

    /// \param degree  p, from 1 to 5.
    /// \param count   m >= p + 1.
    /// \throw InvalidOption  one of them is out of range.
    BsplineBasis(int degree, int count, Ends ends = Ends::uniform);

    int degree() const { return degree_; }
    int count() const { return count_; }
    int spans() const { return count_ - degree_; }

    /// The values of the p + 1 functions that may not be zero at t; their first index is returned.
    /// \param t  moved into [0, 1] if it lies outside.
    /// \param[out] values  (p + 1)
    int values(double t, double* values) const;

    /// The interval on which N_i is not zero; it may go beyond [0, 1].
    std::array<double, 2> support(int i) const { return {knots_[i], knots_[i + degree_ + 1]}; }

    /// The place of coefficient i: with these places as coefficients, the sum of the functions is t.
    double place(int i) const;

private:
    int degree_, count_;
    std::vector<double> knots_; ///< (m + p + 1)
};

} // namespace sinew
