// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// Whether sources named *_avx512.cpp run on this processor.
inline bool has_avx512()
{
#ifdef SINEW_HAVE_AVX2
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
           __builtin_cpu_supports("avx512dq");
#else
    return false;
#endif
}

} // namespace sinew
