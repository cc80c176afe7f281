// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled with AVX2, and run only where the processor has it.
#include "native/solvers/metric_lbfgs_kernels.h"

#include "native/solvers/metric_lbfgs_kernels.inl"

namespace sinew {

extern const LbfgsKernels lbfgs_kernels_with_avx2;
const LbfgsKernels lbfgs_kernels_with_avx2{step, pair, products};

} // namespace sinew
