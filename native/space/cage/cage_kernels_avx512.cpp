// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled with AVX-512, and run only where the processor has it. Eight points side by side.
#ifdef __AVX512DQ__ // nothing elsewhere: other processors, other compilers
#define SINEW_EIGHT_LANES
#include "native/space/cage/cage_kernels.h"

#include <cstddef>

#include "native/space/cage/cage_kernels.inl"

namespace sinew {

extern const CageKernels cage_kernels_with_avx512;
const CageKernels cage_kernels_with_avx512{lane_count, mean_value, green,   arc_integrals, beyond_planes,
                                           nullptr,    nullptr,    nullptr, nullptr};

} // namespace sinew

#endif
