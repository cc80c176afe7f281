// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/metric_lbfgs_kernels.h"

#include "native/core/processor.h"

#include "native/solvers/metric_lbfgs_kernels.inl"

namespace sinew {

#ifdef SINEW_HAVE_AVX2
extern const LbfgsKernels lbfgs_kernels_with_avx2;
#endif

const LbfgsKernels& baseline_lbfgs_kernels()
{
    static constexpr LbfgsKernels kernels{step, pair, products};
    return kernels;
}

const LbfgsKernels* avx2_lbfgs_kernels()
{
#ifdef SINEW_HAVE_AVX2
    if (__builtin_cpu_supports("avx2"))
        return &lbfgs_kernels_with_avx2;
#endif
    return nullptr;
}

const LbfgsKernels& lbfgs_kernels()
{
    static const LbfgsKernels& kernels = widest(baseline_lbfgs_kernels(), avx2_lbfgs_kernels());
    return kernels;
}

} // namespace sinew
