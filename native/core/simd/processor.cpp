// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/simd/processor.h"

#ifdef __x86_64__
#include <cpuid.h>
#endif

namespace sinew {

namespace {

Processor described()
{
    Processor found;
#ifdef __x86_64__
    unsigned a = 0, b = 0, c = 0, d = 0;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_OSXSAVE))
        return found;
    unsigned saved = 0, upper = 0; // a bit for each kind of registers
    __asm__("xgetbv" : "=a"(saved), "=d"(upper) : "c"(0));
    const bool wide = (saved & 0x06) == 0x06, widest = (saved & 0xe6) == 0xe6;
    found.fma = wide && (c & bit_FMA);
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d))
        return found;
    found.avx2 = wide && (b & bit_AVX2);
    found.avx512 = widest && (b & bit_AVX512F) && (b & bit_AVX512VL) && (b & bit_AVX512DQ);
#endif
    return found;
}

} // namespace

const Processor& processor()
{
    static const Processor found = described();
    return found;
}

} // namespace sinew
