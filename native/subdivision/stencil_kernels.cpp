// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/subdivision/stencil_kernels.h"

#include "native/core/processor.h"

#include <cstddef>

#include "native/subdivision/stencil_kernels.inl"

namespace sinew {

#ifdef SINEW_HAVE_AVX2
extern const StencilKernels stencil_kernels_with_avx2;
#endif

const StencilKernels& baseline_stencil_kernels()
{
    static constexpr StencilKernels kernels{rows<double>, rows<float>};
    return kernels;
}

const StencilKernels* avx2_stencil_kernels()
{
#ifdef SINEW_HAVE_AVX2
    if (__builtin_cpu_supports("avx2"))
        return &stencil_kernels_with_avx2;
#endif
    return nullptr;
}

const StencilKernels& stencil_kernels()
{
    static const StencilKernels& kernels = widest(baseline_stencil_kernels(), avx2_stencil_kernels());
    return kernels;
}

} // namespace sinew
