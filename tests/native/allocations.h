// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace sinew::allocations {

/// Whether this build counts: with glibc, and without sanitizers, which have an allocator of their own.
bool counted();

/// Counts what all threads allocate in blocks of at least `least` bytes.
class Count
{
public:
    explicit Count(std::size_t least);
    ~Count();
    Count(const Count&) = delete;
    Count& operator=(const Count&) = delete;

    int so_far() const;
};

} // namespace sinew::allocations
