/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Division of numbers of 128 bits, which Boost's exact numbers and libc++ call. zig has these functions in one object
 * with memcpy, sin, log and others, which would then take the place of the faster ones of the C library. */
#include <stdint.h>

typedef unsigned __int128 Wide;

static Wide divide(Wide n, Wide d, Wide *rest)
{
    const uint64_t high = n >> 64, low = (uint64_t)n, divisor = (uint64_t)d;
    Wide quotient = 0;
    if (d >> 64) {
        int shift = high ? __builtin_clzll(d >> 64) - __builtin_clzll(high) : -1;
        for (; shift >= 0; --shift)
            if (n >= d << shift) {
                n -= d << shift;
                quotient |= (Wide)1 << shift;
            }
        *rest = n;
        return quotient;
    }
    uint64_t last, left;
    __asm__("divq %4" : "=a"(last), "=d"(left) : "a"(low), "d"(high % divisor), "r"(divisor) : "cc");
    *rest = left;
    return (Wide)(high / divisor) << 64 | last;
}

Wide __udivti3(Wide n, Wide d) { return divide(n, d, &n); }
Wide __umodti3(Wide n, Wide d)
{
    divide(n, d, &n);
    return n;
}
__int128 __divti3(__int128 n, __int128 d)
{
    Wide rest;
    const Wide quotient = divide(n < 0 ? -(Wide)n : (Wide)n, d < 0 ? -(Wide)d : (Wide)d, &rest);
    return (n < 0) != (d < 0) ? -quotient : quotient;
}
