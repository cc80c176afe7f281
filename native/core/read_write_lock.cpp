// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/read_write_lock.h"

#include <condition_variable>
#include <mutex>

namespace sinew {

namespace {

// One mutex for all objects, so that a call can take two of them at once. It is held for some instructions.
std::mutex mutex;
int sleepers = 0;
thread_local int held = 0; ///< how many locks this thread has

/// Never destroyed, as threads may still wait when the process ends.
std::condition_variable& freed()
{
    static auto& condition = *new std::condition_variable;
    return condition;
}

} // namespace

/// \param patient  whether to let calls go first that wait to change the objects
bool AccessLock::take(bool patient)
{
    bool possible = true;
    each([&](const ReadWriteLock& one) {
        possible = possible && !one.changing_ &&
                   (kind_ == changing ? one.readers_ == 0 : !patient || one.waiting_ == 0);
    });
    if (possible)
        each([&](ReadWriteLock& one) {
            kind_ == changing ? void(one.changing_ = true) : void(++one.readers_);
        });
    return possible;
}

AccessLock::AccessLock(Kind kind, ReadWriteLock& object, ReadWriteLock& other)
    : kind_(kind), object_(object), other_(other)
{
    std::unique_lock lock(mutex);
    if (held > 0) {
        if (!take(false))
            throw ObjectInUse("the object is in use by another call; a progress callback cannot wait for "
                              "that call to end, so call again later");
    } else if (!take(true)) {
        ++sleepers;
        if (kind_ == changing)
            each([](ReadWriteLock& one) { ++one.waiting_; });
        freed().wait(lock, [this] { return take(true); });
        if (kind_ == changing)
            each([](ReadWriteLock& one) { --one.waiting_; });
        --sleepers;
    }
    ++held;
}

AccessLock::~AccessLock()
{
    bool wake;
    {
        const std::lock_guard lock(mutex);
        --held;
        each([&](ReadWriteLock& one) {
            kind_ == changing ? void(one.changing_ = false) : void(--one.readers_);
        });
        wake = sleepers > 0;
    }
    if (wake)
        freed().notify_all();
}

} // namespace sinew
