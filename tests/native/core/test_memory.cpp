// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/memory.h"

#include "tests/native/refusals.h"

#include <string>

namespace sinew::test_memory {

constexpr std::int64_t megabyte = 1024 * 1024;

TEST(Memory, above_a_limit_that_was_set_is_refused_with_both_sizes_and_a_remedy)
{
    const std::int64_t huge = std::int64_t{1} << 60;
    EXPECT_NO_THROW(require_memory(huge));
    {
        const MemoryLimit limit(2048 * megabyte);
        EXPECT_NO_THROW(require_memory(2048 * megabyte));
        EXPECT_THROW(require_memory(2048 * megabyte + 1), OutOfMemory);
        const auto error = refusal<FactorizationFailed>([] { require_memory(3174 * megabyte); });
        for (const char* part : {"3.1 GB", "2.0 GB", "raise the limit or use fewer vertices"})
            EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
    EXPECT_NO_THROW(require_memory(huge));
}

TEST(Memory, sizes_read_as_people_say_them)
{
    EXPECT_EQ(in_words(0), "0.0 MB");
    EXPECT_EQ(in_words(megabyte / 2), "0.5 MB");
    EXPECT_EQ(in_words(310 * megabyte), "310 MB");
    EXPECT_EQ(in_words(1023 * megabyte + megabyte / 4), "1023 MB");
    EXPECT_EQ(in_words(1024 * megabyte - 1), "1.0 GB");
    EXPECT_EQ(in_words(120 * 1024 * megabyte), "120 GB");
}

} // namespace sinew::test_memory
