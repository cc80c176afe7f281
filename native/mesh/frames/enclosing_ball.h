// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

namespace sinew {

struct Ball
{
    Vector3 centre = Vector3::Zero();
    double radius = 0.0;
};

/// The smallest ball that holds all points (E. Welzl, 1991). It depends neither on the axes nor on how
/// densely places are taken. Cost: O(n), as the points are taken in a random order, the same in each call.
/// \param points  (n, 3), n >= 1
Ball enclosing_ball(const Points& points);

} // namespace sinew
