// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/cage_kernels.h"

#include <cstddef>

#include "native/space/cage/cage_kernels.inl"

namespace sinew {

#ifdef SINEW_HAVE_AVX2
extern const CageKernels cage_kernels_with_avx2;
#endif

const CageKernels& baseline_cage_kernels()
{
    static constexpr CageKernels kernels{
        mean_value, green, product<double>, product<float>, sparse_product<double>, sparse_product<float>};
    return kernels;
}

const CageKernels* avx2_cage_kernels()
{
#ifdef SINEW_HAVE_AVX2
    if (__builtin_cpu_supports("avx2"))
        return &cage_kernels_with_avx2;
#endif
    return nullptr;
}

const CageKernels& cage_kernels()
{
    static const CageKernels& kernels = avx2_cage_kernels() ? *avx2_cage_kernels() : baseline_cage_kernels();
    return kernels;
}

} // namespace sinew
