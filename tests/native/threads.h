// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace sinew {

/// Calls work(0), work(1) ... each in a thread of its own.
template <class Work>
void in_threads(int count, Work&& work)
{
    std::vector<std::thread> threads;
    for (int k = 0; k < count; ++k)
        threads.emplace_back([&work, k] { work(k); });
    for (std::thread& thread : threads)
        thread.join();
}

/// Each of these threads gets the same from `call` every time.
template <class Call, class Value>
void expect_in_threads(int count, int times, Call&& call, const Value& expected)
{
    std::vector<int> wrong(count, 0);
    in_threads(count, [&](int k) {
        for (int time = 0; time < times; ++time)
            wrong[k] += call() != expected;
    });
    EXPECT_EQ(wrong, std::vector<int>(count, 0));
}

} // namespace sinew
