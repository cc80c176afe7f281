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

/// Of one table of kernels for each instruction set, that of the widest there is; null where there is none.
template <class Kernels>
const Kernels& widest(const Kernels& baseline, const Kernels* avx2, const Kernels* avx512 = nullptr)
{
    return avx512 ? *avx512 : avx2 ? *avx2 : baseline;
}

} // namespace sinew
