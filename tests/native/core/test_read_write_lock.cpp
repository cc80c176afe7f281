// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/read_write_lock.h"

#include "tests/native/threads.h"

#include <atomic>
#include <latch>
#include <utility>

namespace sinew::test_read_write_lock {

constexpr auto reading = AccessLock::reading, changing = AccessLock::changing;

TEST(ReadWriteLock, any_number_of_calls_read_at_once)
{
    ReadWriteLock object;
    std::latch all(3);
    in_threads(3, [&](int) {
        const AccessLock shared(reading, object);
        all.arrive_and_wait(); // it would wait for ever if they came one after the other
    });
}

TEST(ReadWriteLock, a_change_has_its_objects_to_itself_in_whatever_order_they_are_taken)
{
    ReadWriteLock first, second;
    int plain = 0, wrong = 0; // a thread sanitizer sees every access that is not in turn
    in_threads(4, [&](int thread) {
        for (int k = 0; k < 500; ++k) {
            if (thread < 2) {
                const AccessLock alone(changing, thread ? first : second, thread ? second : first);
                ++plain;
                wrong += plain % 2 == 0;
                ++plain;
            } else {
                const AccessLock shared(reading, thread == 2 ? first : second);
                EXPECT_EQ(plain % 2, 0);
            }
        }
    });
    EXPECT_EQ(plain, 2000);
    EXPECT_EQ(wrong, 0);
    const AccessLock same(changing, first, first);
}

TEST(ReadWriteLock, a_change_is_not_kept_waiting_by_calls_that_come_later)
{
    ReadWriteLock object;
    std::atomic<bool> changed = false;
    std::latch begun(3);
    in_threads(4, [&](int thread) {
        if (thread == 0) {
            begun.wait();
            const AccessLock alone(changing, object);
            changed = true;
            return;
        }
        bool first = true;
        while (!changed) {
            const AccessLock shared(reading, object);
            if (std::exchange(first, false))
                begun.arrive_and_wait(); // from now on, somebody reads at any time
            std::this_thread::yield();
        }
    });
    EXPECT_TRUE(changed);
}

TEST(ReadWriteLock, a_thread_that_uses_an_object_does_not_wait)
{
    ReadWriteLock object, other;
    const AccessLock shared(reading, object);
    {
        const AccessLock again(reading, object), alone(changing, other);
        EXPECT_THROW(AccessLock(reading, other), ObjectInUse);
        EXPECT_THROW(AccessLock(reading, object, other), ObjectInUse);
        EXPECT_THROW(AccessLock(changing, object), ObjectInUse);
    }
    EXPECT_THROW(AccessLock(changing, object, other), ObjectInUse);
    const AccessLock alone(changing, other);
}

TEST(ReadWriteLock, two_threads_that_use_an_object_each_do_not_wait_for_each_other)
{
    ReadWriteLock first, second;
    std::atomic<int> refused = 0;
    std::latch both(2), done(2);
    in_threads(2, [&](int thread) {
        const AccessLock own(reading, thread ? first : second);
        both.arrive_and_wait();
        try {
            const AccessLock others(changing, thread ? second : first);
        } catch (const ObjectInUse&) {
            ++refused;
        }
        done.arrive_and_wait();
    });
    EXPECT_EQ(refused, 2);
}

} // namespace sinew::test_read_write_lock
