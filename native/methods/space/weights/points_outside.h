// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/errors.h"

namespace sinew {

/// Points lie outside the control, where the method cannot move them. The elements are these points.
class PointsOutside : public InvalidConstraint
{
    using InvalidConstraint::InvalidConstraint;
};

} // namespace sinew
