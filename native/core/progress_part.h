// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"

#include <algorithm>

namespace sinew {

/// The progress of a part of the work, which takes the whole from one fraction to another.
inline Progress part_of(const Progress& whole, double from, double to)
{
    return Progress([whole, from, to](double fraction, const char* stage) {
        whole.tick(from + (to - from) * std::min(fraction, 1.0), stage);
        return true;
    });
}

} // namespace sinew
