// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/parallel.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <memory>
#include <mutex>

namespace sinew {

void parallel_chunks(int count, int grain, const std::function<void(int, int)>& body)
{
    const int chunks = (count + grain - 1) / grain;
    // For so few chunks, waking a second thread costs more time than it saves.
    if (chunks < 4) {
        for (int c = 0; c < chunks; ++c)
            body(c * grain, std::min(count, (c + 1) * grain));
        return;
    }
    tbb::parallel_for(0, chunks, [&](int c) { body(c * grain, std::min(count, (c + 1) * grain)); });
}

void parallel_tasks(int count, const std::function<void(int)>& body)
{
    tbb::parallel_for(0, count, [&](int task) { body(task); }, tbb::simple_partitioner());
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
