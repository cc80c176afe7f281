// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/errors.h"

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

} // namespace sinew
