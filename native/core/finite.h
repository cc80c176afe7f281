// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace sinew {

/// Whether all numbers of an array are finite. Zero times any other is not a number, and a sum keeps that;
/// unlike allFinite(), it reads whole registers.
template <class Derived>
bool all_finite(const Eigen::DenseBase<Derived>& numbers)
{
    return (numbers.derived().array() * typename Derived::Scalar(0)).sum() == 0;
}

} // namespace sinew
