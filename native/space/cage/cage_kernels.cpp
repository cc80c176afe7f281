// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/cage_kernels.h"

#include "native/core/processor.h"

#include <cstddef>

#include "native/space/cage/cage_kernels.inl"
#include "native/space/cage/cage_products.inl"

namespace sinew {

#ifdef SINEW_HAVE_AVX2
extern const CageKernels cage_kernels_with_avx2, cage_kernels_with_avx512;
#endif

const CageKernels& baseline_cage_kernels()
{
    static constexpr CageKernels kernels{
        lane_count,           mean_value,      green,          arc_integrals,
        beyond_planes,        product<double>, product<float>, sparse_product<double>,
        sparse_product<float>};
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

const CageKernels* avx512_cage_kernels()
{
#ifdef SINEW_HAVE_AVX2
    if (has_avx512()) {
        // The products wait for memory: AVX2 is enough for them.
        static const CageKernels kernels = [] {
            CageKernels both = cage_kernels_with_avx2;
            both.lanes = cage_kernels_with_avx512.lanes;
            both.mean_value = cage_kernels_with_avx512.mean_value;
            both.green = cage_kernels_with_avx512.green;
            both.arc_integrals = cage_kernels_with_avx512.arc_integrals;
            both.beyond_planes = cage_kernels_with_avx512.beyond_planes;
            return both;
        }();
        return &kernels;
    }
#endif
    return nullptr;
}

const CageKernels& cage_kernels()
{
    static const CageKernels& kernels =
        widest(baseline_cage_kernels(), avx2_cage_kernels(), avx512_cage_kernels());
    return kernels;
}

} // namespace sinew
