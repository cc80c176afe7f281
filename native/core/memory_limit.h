// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace sinew {

/// What limit_memory() was given last; 0 for no limit.
std::int64_t memory_limit();

} // namespace sinew
