// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <cstdint>
#include <vector>

namespace sinew {

/// The places of points along a curve that fills their bounding box (G. M. Morton, 1966): points that are
/// near along it are near in space. 21 bits per axis, with cubes as cells.
std::vector<std::uint64_t> morton_codes(PointsView points);

/// The points in that order, with 10 bits per axis; those of one cell by rising index. Cost: O(n).
std::vector<int> space_order(PointsView points);

} // namespace sinew
