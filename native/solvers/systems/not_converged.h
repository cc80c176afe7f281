// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/errors.h"

namespace sinew {

/// An iteration used up its steps, or moves away from the solution.
class NotConverged : public Error
{
    using Error::Error;
};

} // namespace sinew
