// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/skeleton/skeleton.h"

#include <optional>
#include <vector>

namespace sinew {

/// The axes about which a joint turns, when it has a hinge: the hinge, along the bone, and across both; by
/// columns, in the bone's own axes at rest.
using Hinge = std::optional<Matrix3>;

/// (bones) The hinges of the joints without limits, such as knees, elbows and fingers.
///
/// A joint has one where the skeleton goes on by one bone only: its bone is the only one of its parent that
/// carries bones itself, or the only one at all. Hips and shoulders, from which several limbs go on, have
/// none, nor has a bone without a parent.
///
/// The hinge is at right angles to the bone and its parent at rest, and a positive turn bends further. A
/// joint that is straight at rest has none: a tail bends to all sides.
std::vector<Hinge> hinges(const Skeleton& skeleton);

} // namespace sinew
