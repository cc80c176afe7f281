// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/errors.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace sinew {

/// Reports progress to the caller and lets the caller cancel. Long calls tick between their stages, at least
/// once per factorisation and per iteration, always from the calling thread.
class Progress
{
public:
    /// Gets the share that is done, in [0, 1], and the name of the stage; returns false to cancel.
    using Callback = std::function<bool(double fraction, const char* stage)>;

    Progress() = default;
    explicit Progress(Callback callback) : callback_(std::move(callback)) {}

    /// \throw Cancelled  the callback returned false.
    void tick(double fraction, const char* stage) const
    {
        if (callback_ && !callback_(fraction, stage))
            throw Cancelled(std::string("cancelled while ") + stage);
    }

private:
    Callback callback_;
};

/// The progress of a part of the work, which takes the whole from one fraction to another.
inline Progress part_of(const Progress& whole, double from, double to)
{
    return Progress([whole, from, to](double fraction, const char* stage) {
        whole.tick(from + (to - from) * std::min(fraction, 1.0), stage);
        return true;
    });
}

} // namespace sinew
