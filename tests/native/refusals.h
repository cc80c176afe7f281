// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

/// What the tests of refusals and of limits share.
namespace sinew {

/// The error that a call is refused with.
template <class E, class Call>
E refusal(Call&& call)
{
    try {
        call();
    } catch (const E& error) {
        return error;
    }
    ADD_FAILURE() << "not refused";
    return E("");
}

inline void expect_elements(const Error& error, Error::Element kind, const std::vector<int>& elements)
{
    EXPECT_EQ(error.element_kind(), kind) << error.what();
    EXPECT_EQ(error.elements(), elements) << error.what();
}

/// Lifts the limit again, however the test ends.
struct MemoryLimit
{
    explicit MemoryLimit(std::int64_t bytes) { limit_memory(bytes); }
    ~MemoryLimit() { limit_memory(0); }
};

/// Likewise.
struct ThreadLimit
{
    explicit ThreadLimit(int count) { limit_threads(count); }
    ~ThreadLimit() { limit_threads(0); }
};

} // namespace sinew
