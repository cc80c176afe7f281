// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <vector>

namespace sinew {

/// Indices of at most `count` points: `first`, and then always the one farthest from all before; of several,
/// the lowest. Points that coincide with earlier ones are left out. Cost: O(n count).
std::vector<int> farthest_points(const std::vector<Vector3>& points, int count, int first);

} // namespace sinew
