// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/harmonic_layers.h"

#include "native/core/processor.h"

#include <cmath>
#include <cstddef>

#include "native/space/cage/harmonic_layers.inl"

namespace sinew {

#ifdef SINEW_HAVE_AVX2
extern const LayerKernels layer_kernels_with_avx2, layer_kernels_with_avx512;
#endif

const LayerKernels& baseline_layer_kernels()
{
    static constexpr LayerKernels kernels{single, both};
    return kernels;
}

const LayerKernels* avx2_layer_kernels()
{
#ifdef SINEW_HAVE_AVX2
    if (__builtin_cpu_supports("avx2"))
        return &layer_kernels_with_avx2;
#endif
    return nullptr;
}

const LayerKernels* avx512_layer_kernels()
{
#ifdef SINEW_HAVE_AVX2
    if (has_avx512())
        return &layer_kernels_with_avx512;
#endif
    return nullptr;
}

const LayerKernels& layer_kernels()
{
    static const LayerKernels& kernels =
        widest(baseline_layer_kernels(), avx2_layer_kernels(), avx512_layer_kernels());
    return kernels;
}

} // namespace sinew
