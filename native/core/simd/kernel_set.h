// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/simd/processor.h"

#include <initializer_list>

namespace sinew {

/// A set of kernels is a struct of function pointers, written once in an .inl file and compiled once for each
/// set of instructions (sinew_add_kernels in native/cmake). It declares one static member of its own type for
/// each set that the build makes: `baseline`, `avx2` and, where eight lanes are faster than four, `avx512`.
enum class Instructions { baseline, avx2, avx512 };

/// The kernels compiled with these instructions; null where the processor lacks the instructions, or the
/// build made no such kernels.
template <class Kernels>
const Kernels* kernels_with(Instructions instructions)
{
#ifdef SINEW_HAVE_WIDE_KERNELS
    if (instructions == Instructions::avx2 && processor().avx2)
        return &Kernels::avx2;
    if constexpr (requires { Kernels::avx512; })
        if (instructions == Instructions::avx512 && processor().avx512)
            return &Kernels::avx512;
#endif
    return instructions == Instructions::baseline ? &Kernels::baseline : nullptr;
}

/// The widest instructions that kernels use on this processor, in the words of its maker.
inline const char* widest_instructions()
{
#if defined(SINEW_HAVE_WIDE_KERNELS)
    return processor().avx512 ? "AVX-512" : processor().avx2 ? "AVX2" : "SSE4.2";
#elif defined(__ARM_NEON)
    return "NEON";
#else
    return "those of every processor";
#endif
}

/// The kernels with the widest instructions that this processor runs.
template <class Kernels>
const Kernels& widest_kernels()
{
    static const Kernels& widest = []() -> const Kernels& {
        for (const Instructions instructions : {Instructions::avx512, Instructions::avx2})
            if (const Kernels* kernels = kernels_with<Kernels>(instructions))
                return *kernels;
        return Kernels::baseline;
    }();
    return widest;
}

} // namespace sinew
