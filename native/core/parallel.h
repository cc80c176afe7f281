// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <vector>

namespace sinew {

/// Runs body(begin, end) over [0, count) in chunks of `grain`. Where the chunks begin depends on count and
/// grain only, never on the number of threads, so sums that are gathered per chunk are reproducible to the
/// last bit on every machine.
void parallel_chunks(int count, int grain, const std::function<void(int begin, int end)>& body);

/// Runs body(task) once for each of a few heavy tasks, in any order.
void parallel_tasks(int count, const std::function<void(int task)>& body);

/// Runs body(i) for every i in [0, count). The calls must not depend on each other.
template <class Body>
void parallel_for(int count, Body&& body, int grain = 2048)
{
    parallel_chunks(count, grain, [&](int begin, int end) {
        for (int i = begin; i < end; ++i)
            body(i);
    });
}

/// The sum of body(i), added up in an order that does not depend on the number of threads.
template <class Body>
double parallel_sum(int count, Body&& body, int grain = 2048)
{
    std::vector<double> partial((count + grain - 1) / grain, 0.0);
    parallel_chunks(count, grain, [&](int begin, int end) {
        double sum = 0.0;
        for (int i = begin; i < end; ++i)
            sum += body(i);
        partial[begin / grain] = sum;
    });
    double total = 0.0;
    for (double sum : partial)
        total += sum;
    return total;
}

/// At most `count` threads in the library's own loops; 0 lifts the limit.
void limit_threads(int count);

} // namespace sinew
