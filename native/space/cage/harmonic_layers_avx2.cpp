// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled with AVX2, and run only where the processor has it.
#include "native/space/cage/harmonic_layers.h"

#include <cmath>
#include <cstddef>

#include "native/space/cage/harmonic_layers.inl"

namespace sinew {

extern const LayerKernels layer_kernels_with_avx2;
const LayerKernels layer_kernels_with_avx2{single, both};

} // namespace sinew
