// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/parallel.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <memory>
#include <mutex>

#ifdef __SANITIZE_THREAD__
#include <atomic>
#include <future>
#endif

namespace sinew {

#ifdef __SANITIZE_THREAD__

namespace {

/// Stands in for oneTBB, which is compiled without the thread sanitizer: its hand-over of work would look
/// like a race. Two threads share the calls.
void in_two_threads(int count, const std::function<void(int)>& body)
{
    std::atomic<int> next = 0;
    const auto work = [&] {
        for (int i = next++; i < count; i = next++)
            body(i);
    };
    auto other = std::async(std::launch::async, work);
    work();
    other.get();
}

} // namespace

#endif

void parallel_chunks(int count, int grain, const std::function<void(int, int)>& body)
{
    const int chunks = (count + grain - 1) / grain;
    // For so few chunks, waking a second thread costs more time than it saves.
    if (chunks < 4) {
        for (int c = 0; c < chunks; ++c)
            body(c * grain, std::min(count, (c + 1) * grain));
        return;
    }
    const auto chunk = [&](int c) { body(c * grain, std::min(count, (c + 1) * grain)); };
#ifdef __SANITIZE_THREAD__
    in_two_threads(chunks, chunk);
#else
    tbb::parallel_for(0, chunks, chunk);
#endif
}

void parallel_tasks(int count, const std::function<void(int)>& body)
{
#ifdef __SANITIZE_THREAD__
    in_two_threads(count, body);
#else
    tbb::parallel_for(0, count, [&](int task) { body(task); }, tbb::simple_partitioner());
#endif
}

void limit_threads(int count)
{
    static std::mutex mutex;
    static std::unique_ptr<tbb::global_control> control;
    const std::lock_guard lock(mutex);
    control.reset();
    if (count > 0)
        control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                        static_cast<std::size_t>(count));
}

} // namespace sinew
