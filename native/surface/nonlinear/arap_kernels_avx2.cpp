// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled with AVX2, and run only where the processor has it.
#include "native/surface/nonlinear/arap_kernels.h"

#include <cmath>
#include <cstddef>

#include "native/surface/nonlinear/arap_kernels.inl"

namespace sinew {

extern const ArapKernels arap_kernels_with_avx2;
const ArapKernels arap_kernels_with_avx2{covariances, add_neighbours, torques, turn, fit, energy};

} // namespace sinew
