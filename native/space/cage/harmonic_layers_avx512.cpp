// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled with AVX-512, and run only where the processor has it. Eight points side by side.
#ifdef __AVX512DQ__ // nothing elsewhere: other processors, other compilers
#define SINEW_EIGHT_LANES
#include "native/space/cage/harmonic_layers.h"

#include <cmath>
#include <cstddef>

#include "native/space/cage/harmonic_layers.inl"

namespace sinew {

extern const LayerKernels layer_kernels_with_avx512;
const LayerKernels layer_kernels_with_avx512{single, both};

} // namespace sinew

#endif
