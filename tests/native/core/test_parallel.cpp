// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/parallel.h"

#include "tests/native/refusals.h"

#include <cmath>
#include <stdexcept>

namespace sinew::test_parallel {

/// A sum whose value depends on the order of its terms.
double touchy_sum()
{
    return parallel_sum(100'000, [](int i) { return std::sin(i) * std::pow(10.0, i % 17 - 8); }, 500);
}

TEST(Parallel, sums_are_equal_to_the_bit_for_any_thread_limit)
{
    EXPECT_EQ(parallel_sum(0, [](int) { return 1.0; }), 0.0);
    const double free = touchy_sum();
    for (int threads : {1, 2, 3, 8}) {
        const ThreadLimit limit(threads);
        std::vector<int> ends(10, 0); // which depend on the grain alone
        parallel_chunks(95, 10, [&](int begin, int end) { ends[begin / 10] = end; });
        EXPECT_EQ(ends, (std::vector{10, 20, 30, 40, 50, 60, 70, 80, 90, 95}));
        for (int repeat = 0; repeat < 5; ++repeat)
            EXPECT_EQ(touchy_sum(), free) << threads << " threads";
    }
}

TEST(Parallel, every_item_is_visited_once_and_errors_of_the_body_reach_the_caller)
{
    for (int count : {0, 1, 9, 10, 11, 39, 40, 41, 1000}) {
        std::vector<int> visits(count, 0);
        parallel_for(count, [&](int i) { ++visits[i]; }, 10);
        EXPECT_EQ(visits, std::vector<int>(count, 1)) << count << " items";
    }
    const auto fail = [](int i) {
        if (i == 777)
            throw std::runtime_error("777");
    };
    EXPECT_THROW(parallel_for(1000, fail, 10), std::runtime_error);
    EXPECT_THROW(parallel_for(1000, fail, 1000), std::runtime_error);
}

} // namespace sinew::test_parallel
