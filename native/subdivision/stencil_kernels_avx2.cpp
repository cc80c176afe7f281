// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled with AVX2, and run only where the processor has it.
#include "native/subdivision/stencil_kernels.h"

#include <cstddef>

#include "native/subdivision/stencil_kernels.inl"

namespace sinew {

extern const StencilKernels stencil_kernels_with_avx2;
const StencilKernels stencil_kernels_with_avx2{rows<double>, rows<float>};

} // namespace sinew
