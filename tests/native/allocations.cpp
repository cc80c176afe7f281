// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/native/allocations.h"

#include <atomic>
#include <cstdlib>
#include <limits>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SINEW_COUNTS_ALLOCATIONS 1
#else
#define SINEW_COUNTS_ALLOCATIONS 0
#endif

namespace {

std::atomic<std::size_t> least = std::numeric_limits<std::size_t>::max();
std::atomic<int> found = 0;

} // namespace

#if SINEW_COUNTS_ALLOCATIONS
// The C library's own names give way to those of a program; operator new and Eigen come here, too.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

static void note(std::size_t bytes)
{
    if (bytes >= least.load(std::memory_order_relaxed))
        ++found;
}
void* malloc(std::size_t bytes) noexcept
{
    note(bytes);
    return __libc_malloc(bytes);
}
void* calloc(std::size_t count, std::size_t bytes) noexcept
{
    note(count * bytes);
    return __libc_calloc(count, bytes);
}
void* realloc(void* block, std::size_t bytes) noexcept
{
    note(bytes);
    return __libc_realloc(block, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept
{
    note(bytes);
    return __libc_memalign(alignment, bytes);
}
}
#endif

namespace sinew::allocations {

bool counted() { return SINEW_COUNTS_ALLOCATIONS; }

Count::Count(std::size_t bytes)
{
    found = 0;
    least = bytes;
}
Count::~Count() { least = std::numeric_limits<std::size_t>::max(); }
int Count::so_far() const { return found; }

} // namespace sinew::allocations
