// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace sinew {

/// What follows is advice to the operating system. One that knows no such advice ignores it, and no result
/// depends on it.

/// A factor is written once and read as a whole in every frame. Large pages save a page fault per 4 KB when
/// it is written, and most address translations when it is read. Only Linux is asked; the contents stay.
void ask_for_large_pages(void* memory, std::size_t bytes);

/// Returns memory that was freed to the system, before a large block is allocated. Only glibc is asked.
void return_freed_memory();

} // namespace sinew
