// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <Eigen/Core>

#include <string>

namespace sinew {

/// Whether all numbers of an array are finite. Zero times any other is not a number, and a sum keeps that;
/// unlike allFinite(), it reads whole registers.
template <class Derived>
bool all_finite(const Eigen::DenseBase<Derived>& numbers)
{
    return (numbers.derived().array() * typename Derived::Scalar(0)).sum() == 0;
}

/// Points (n, 3) of single precision.
using SinglePoints = Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>;

/// Whether all points are finite, on all threads.
bool are_finite(const Points& points);
bool are_finite(const SinglePoints& points);

/// Rounds points to single precision, on all threads. \return whether all results are finite.
bool round_points(const Points& points, SinglePoints& rounded);

/// A number in as many digits as a message needs, such as 0.25 or 1e-07.
std::string shortest(double number, int digits = 6);

} // namespace sinew
