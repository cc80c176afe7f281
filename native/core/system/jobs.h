// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

namespace sinew {

/// Runs body(job) once for each of many jobs that have parallel loops of their own, in any order. Uses task
/// isolation: a thread that waits inside such a loop does not steal another job.
void parallel_jobs(int count, const std::function<void(int job)>& body);

} // namespace sinew
