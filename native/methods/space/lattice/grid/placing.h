// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/methods/space/lattice/grid/placed_points.h"
#include "native/methods/space/method.h"

#include <functional>

namespace sinew {

/// Finds the places of points, in threads, and names those outside in the report. `where` may be called by
/// several threads at once.
PlacedPoints placed_points(PointsView points, int cells,
                           const std::function<LatticePlace(const Vector3&)>& where, SpaceReport& report,
                           const Progress& progress);

template <class Lattice>
PlacedPoints placed_in(const Lattice& lattice, PointsView points, SpaceReport& report,
                       const Progress& progress)
{
    return placed_points(
        points, lattice.cell_count(), [&](const Vector3& point) { return lattice.place(point); }, report,
        progress);
}

/// \throw InvalidConstraint  a posed control has another number of points than at rest, or some are not
///   finite.
/// \param control  what it is called: "lattice"
void check_pose_of(const char* control, PointsView posed, int expected);

} // namespace sinew
