// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

namespace sinew {

/// No factor and no weights of a cage may take more than `bytes`; 0 lifts the limit. What stands already is
/// kept.
void limit_memory(std::int64_t bytes);

/// \param what  needs them, for the message.
/// \throw OutOfMemory  `bytes` is more than the limit; both are named.
void require_memory(std::int64_t bytes, const char* what = "the factor");

/// "3.1 GB", "310 MB" or "0.4 MB", for messages; a GB is 1024^3 bytes, as Blender counts.
std::string in_words(std::int64_t bytes);

} // namespace sinew
