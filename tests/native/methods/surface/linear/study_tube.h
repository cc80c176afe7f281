// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "tests/native/shapes.h"

#include <cmath>

namespace sinew {

/// A closed tube of the radius 1 along x, 28 x 80 quads, each cut in two, and a fan on each end.
SurfaceMesh study_tube();

double rms_edge_ratio(const SurfaceMesh& mesh, const Points& q);

/// What the faces enclose over other points.
double enclosed_volume(const SurfaceMesh& mesh, const Points& q);

inline constexpr double study_depth = 2.9; ///< of the handles at its ends: all that is nearer than 3

/// The motion of the end at x = 20 where the axis between 3 and 17 becomes an arc of 120 degrees.
Pose study_bend();

} // namespace sinew
