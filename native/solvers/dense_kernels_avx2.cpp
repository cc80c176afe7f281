// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled with AVX2, and run only where the processor has it.
#include "native/solvers/dense_kernels.h"

#include <cmath>
#include <cstddef>

#include "native/solvers/dense_kernels.inl"

namespace sinew {

extern const DenseKernels dense_kernels_with_avx2;
const DenseKernels dense_kernels_with_avx2{add_product};

} // namespace sinew
