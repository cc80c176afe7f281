// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <memory>

namespace sinew {

/// A workspace cached between calls, so that its memory stays mapped. Any number of threads may take one at a
/// time: the first gets the cached object, the others new ones; the one that is given back last is cached.
///
/// A `thread_local` object would take as much memory for each thread until that ends; and with GCC for Windows
/// the storage of such objects is freed before their destructors run, so that threads and programs crash.
template <class T>
class Kept
{
public:
    Kept() = default;
    Kept(const Kept&) = delete;
    Kept& operator=(const Kept&) = delete;
    ~Kept() { delete waiting_.load(); }

    std::unique_ptr<T> take()
    {
        T* const waiting = waiting_.exchange(nullptr);
        return waiting ? std::unique_ptr<T>(waiting) : std::make_unique<T>();
    }
    void give_back(std::unique_ptr<T> used) { delete waiting_.exchange(used.release()); }

private:
    std::atomic<T*> waiting_{nullptr};
};

} // namespace sinew
