// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

namespace sinew {

/// Runs body(job) once for each of many jobs that have parallel loops of their own, in any order. A thread
/// that waits for others in such a loop begins no other job meanwhile.
void parallel_jobs(int count, const std::function<void(int job)>& body);

} // namespace sinew
