// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled with AVX-512, and run only where the processor has it. Eight numbers side by side.
#ifdef __AVX512DQ__ // nothing elsewhere: other processors, other compilers
#define SINEW_EIGHT_LANES
#include "native/solvers/dense_kernels.h"

#include <cmath>
#include <cstddef>

#include "native/solvers/dense_kernels.inl"

namespace sinew {

extern const DenseKernels dense_kernels_with_avx512;
const DenseKernels dense_kernels_with_avx512{add_product};

} // namespace sinew

#endif
