// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/memory.h"

#include "native/core/errors.h"

#include <atomic>
#include <cstdio>

namespace sinew {

namespace {

std::atomic<std::int64_t> limit = 0;

} // namespace

void limit_memory(std::int64_t bytes) { limit = bytes > 0 ? bytes : 0; }

std::int64_t memory_limit() { return limit; }

void require_memory(std::int64_t bytes, const char* what)
{
    const std::int64_t most = limit;
    if (most > 0 && bytes > most)
        throw OutOfMemory(std::string(what) + " needs " + in_words(bytes) + ", the memory limit is " +
                          in_words(most) + ": raise the limit or use fewer vertices");
}

std::string in_words(std::int64_t bytes)
{
    const double megabytes = static_cast<double>(bytes) / (1024.0 * 1024.0);
    const bool large = megabytes >= 1023.5; // from here on megabytes would be rounded to 1024 MB
    const double value = large ? megabytes / 1024.0 : megabytes;
    char text[32];
    std::snprintf(text, sizeof text, value < 99.95 ? "%.1f %s" : "%.0f %s", value, large ? "GB" : "MB");
    return text;
}

} // namespace sinew
