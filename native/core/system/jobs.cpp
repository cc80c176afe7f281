// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/system/jobs.h"

#ifdef __SANITIZE_THREAD__
#include "native/core/parallel.h"
#else
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#endif

namespace sinew {

void parallel_jobs(int count, const std::function<void(int)>& body)
{
#ifdef __SANITIZE_THREAD__
    parallel_tasks(count, body); // by a loop that the sanitizer can follow, see there
#else
    tbb::parallel_for(
        0, count, [&](int job) { tbb::this_task_arena::isolate([&] { body(job); }); },
        tbb::simple_partitioner());
#endif
}

} // namespace sinew
