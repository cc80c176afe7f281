// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/nonlinear/arap_kernels.h"

#include "native/core/processor.h"

#include <cmath>
#include <cstddef>

#include "native/surface/nonlinear/arap_kernels.inl"

namespace sinew {

#ifdef SINEW_HAVE_AVX2
extern const ArapKernels arap_kernels_with_avx2;
#endif

const ArapKernels& baseline_arap_kernels()
{
    static constexpr ArapKernels kernels{covariances, add_neighbours, torques, turn, fit, energy};
    return kernels;
}

const ArapKernels* avx2_arap_kernels()
{
#ifdef SINEW_HAVE_AVX2
    if (__builtin_cpu_supports("avx2"))
        return &arap_kernels_with_avx2;
#endif
    return nullptr;
}

const ArapKernels& arap_kernels()
{
    static const ArapKernels& kernels = widest(baseline_arap_kernels(), avx2_arap_kernels());
    return kernels;
}

} // namespace sinew
