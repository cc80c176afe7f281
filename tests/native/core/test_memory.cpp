// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/memory.h"

#include "tests/native/refusals.h"

#include <string>

namespace sinew::test_memory {

constexpr std::int64_t megabyte = 1024 * 1024;

TEST(Memory, is_not_limited_until_a_limit_is_set)
{
    EXPECT_NO_THROW(require_memory(std::int64_t{1} << 60));
    {
        const MemoryLimit limit(megabyte);
        EXPECT_THROW(require_memory(std::int64_t{1} << 60), OutOfMemory);
    }
    EXPECT_NO_THROW(require_memory(std::int64_t{1} << 60));
}

TEST(Memory, of_exactly_the_limit_is_allowed)
{
    const MemoryLimit limit(megabyte);
    EXPECT_NO_THROW(require_memory(megabyte));
    EXPECT_THROW(require_memory(megabyte + 1), OutOfMemory);
}

TEST(Memory, refusal_names_both_sizes_and_a_remedy)
{
    const MemoryLimit limit(2048 * megabyte);
    const auto error = refusal<FactorizationFailed>([] { require_memory(3174 * megabyte); });
    for (const char* part : {"3.1 GB", "2.0 GB", "raise the limit or use fewer vertices"})
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
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
