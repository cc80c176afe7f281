// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace sinew {

/// No factor and no weights of points may take more than `bytes`; 0 lifts the limit. What has been computed
/// already is kept.
void limit_memory(std::int64_t bytes);
/// What limit_memory() was given last; 0 for no limit.
std::int64_t memory_limit();

/// \param what  the thing that needs `bytes`, for the message.
/// \throw OutOfMemory  `bytes` is more than the limit; the message names both.
void require_memory(std::int64_t bytes, const char* what = "the factor");

/// "3.1 GB", "310 MB" or "0.4 MB", for messages; a GB is 1024^3 bytes, as Blender counts.
std::string in_words(std::int64_t bytes);

/// Workspaces that are kept from call to call, so that only the first call allocates memory. Each of several
/// calls at the same time has its own.
template <class T>
class Pool
{
public:
    /// A workspace that returns to its pool when the lease ends.
    class Lease
    {
    public:
        Lease(Pool& pool, std::unique_ptr<T> work) : pool_(pool), work_(std::move(work)) {}
        ~Lease()
        {
            const std::lock_guard lock(pool_.mutex_);
            pool_.idle_.push_back(std::move(work_));
        }
        Lease(const Lease&) = delete;
        Lease& operator=(const Lease&) = delete;

        T& operator*() const { return *work_; }
        T* operator->() const { return work_.get(); }

    private:
        Pool& pool_;
        std::unique_ptr<T> work_;
    };

    /// \param make  makes a std::unique_ptr<T>; called where no workspace is idle.
    template <class Make>
    Lease take(Make&& make)
    {
        {
            const std::lock_guard lock(mutex_);
            if (!idle_.empty()) {
                std::unique_ptr<T> work = std::move(idle_.back());
                idle_.pop_back();
                return {*this, std::move(work)};
            }
        }
        return {*this, make()};
    }

    /// Frees the workspaces that are idle.
    void clear()
    {
        const std::lock_guard lock(mutex_);
        idle_.clear();
    }

private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<T>> idle_;
};

} // namespace sinew
