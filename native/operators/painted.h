// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace sinew {

/// A parameter that is one number, or one per vertex (painted), as one value for each of n vertices; empty
/// where it is zero everywhere. Painted values below `least` times their largest are raised to that, so that
/// a region painted black stays solvable.
/// \param name  of the parameter, for messages.
/// \throw InvalidOption  another number of values, or one that is negative or not finite.
std::vector<double> painted(const std::vector<double>& values, int n, double least, const char* name);

} // namespace sinew
