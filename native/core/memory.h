// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

namespace sinew {

/// No factor may take more than `bytes`; 0 lifts the limit. Factors that stand already are kept.
void limit_memory(std::int64_t bytes);

/// \throw OutOfMemory  `bytes` is more than the limit; both are named.
void require_memory(std::int64_t bytes);

/// "3.1 GB", "310 MB" or "0.4 MB", for messages; a GB is 1024^3 bytes, as Blender counts.
std::string in_words(std::int64_t bytes);

} // namespace sinew
