// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace sinew {

/// One value for each of n vertices, from a parameter that is one number or one number per vertex (painted).
/// Empty where the parameter is zero everywhere. Painted values below `least` times the largest one are
/// raised to that, so that the system stays solvable where a region is painted black.
/// \param name  the name of the parameter, for messages.
/// \throw InvalidOption  there are neither 1 nor n values, or a value is negative or not finite.
std::vector<double> painted(const std::vector<double>& values, int n, double least, const char* name);

} // namespace sinew
