// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/errors.h"

#include <functional>
#include <utility>

namespace sinew {

/// Progress out, cancellation in. Long calls tick between their stages, at least
/// once per factorisation and per iteration, always from the calling thread.
class Progress
{
public:
    /// Takes the share done, in [0, 1], and the stage's name; false cancels.
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
