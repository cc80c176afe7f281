// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/methods/space/cage/closed_forms/cage_geometry.h"

#include <vector>

namespace sinew {

/// The weights of MeanValue for a block of points.
/// \param[out] rows     (b, vertices of the cage)
/// \param[out] outside  (b) whether each point lies outside.
void mean_value_weights(const CageGeometry& geometry, PointsView block, RowMatrix& rows,
                        std::vector<char>& outside);

} // namespace sinew
