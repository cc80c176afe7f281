// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/system/jobs.h"

#include "native/core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

namespace sinew::test_jobs {

TEST(Jobs, a_thread_that_waits_within_a_job_begins_no_other)
{
    std::atomic<int> nested = 0;
    std::vector<int> visits(64, 0);
    parallel_jobs(64, [&](int job) {
        thread_local bool busy = false;
        nested += busy;
        busy = true;
        parallel_for(200, [](int) { std::this_thread::sleep_for(std::chrono::nanoseconds(1)); }, 50);
        busy = false;
        ++visits[job];
    });
    EXPECT_EQ(nested, 0);
    EXPECT_EQ(visits, std::vector<int>(64, 1));
}

TEST(Jobs, errors_reach_the_caller)
{
    const auto fail = [](int job) {
        if (job == 7)
            throw std::runtime_error("7");
    };
    EXPECT_THROW(parallel_jobs(20, fail), std::runtime_error);
    parallel_jobs(0, fail);
}

} // namespace sinew::test_jobs
