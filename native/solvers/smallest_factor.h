// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/solvers/orderings.h"

namespace sinew {

/// The ordering of the smallest factors: nested dissection in builds that have it, otherwise minimum degree.
Ordering smallest_factor();

} // namespace sinew
