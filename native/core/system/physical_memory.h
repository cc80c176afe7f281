// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace sinew {

/// The bytes of memory that this machine has, or, where that is less, that the container has in which this process runs.
/// 0 where the system does not say.
std::int64_t physical_memory();

} // namespace sinew
