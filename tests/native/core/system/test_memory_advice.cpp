// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/system/memory_advice.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

using namespace sinew;

TEST(Pages, advice_leaves_the_contents_alone)
{
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{100}, std::size_t{6} << 20}) {
        std::vector<unsigned char> memory(size);
        for (std::size_t i = 0; i < size; ++i)
            memory[i] = static_cast<unsigned char>(i % 251);
        ask_for_large_pages(memory.data(), memory.size());
        return_freed_memory();
        for (std::size_t i = 0; i < size; ++i)
            ASSERT_EQ(memory[i], i % 251) << i << " of " << size;
    }
}
