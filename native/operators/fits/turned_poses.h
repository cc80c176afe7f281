// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <array>
#include <vector>

namespace sinew {

/// How points turn that are only known to move: (n) rigid motions, each of which takes its point from `rest`
/// to `posed`, (n, 3) each.
///
/// A motion turns as the edges at the point do, by the best rotation; a little as all points do, too, which
/// decides where the edges leave a turn open, and alone for a point without edges.
///
/// \throw InvalidConstraint  the shapes differ, a coordinate is not finite, or an edge has other points.
Poses turned_poses(PointsView rest, PointsView posed, const std::vector<std::array<int, 2>>& edges);

} // namespace sinew
