// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// While it lives, this thread computes with all 64 bits of a long double, also on Windows, where threads
/// begin with 53. An oracle that waits for the last bit of a long double would wait for ever there.
class LongDoubles
{
public:
    LongDoubles()
    {
#if defined(__x86_64__) && defined(__GNUC__)
        asm volatile("fnstcw %0" : "=m"(before_));
        const unsigned short full = before_ | 0x0300;
        asm volatile("fldcw %0" : : "m"(full));
#endif
    }
    ~LongDoubles()
    {
#if defined(__x86_64__) && defined(__GNUC__)
        asm volatile("fldcw %0" : : "m"(before_));
#endif
    }
    LongDoubles(const LongDoubles&) = delete;
    LongDoubles& operator=(const LongDoubles&) = delete;

private:
    [[maybe_unused]] unsigned short before_ = 0;
};

} // namespace sinew
