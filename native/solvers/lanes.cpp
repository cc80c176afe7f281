// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/lanes.h"

#include "native/solvers/lanes.inl"

namespace sinew {

#ifdef SINEW_HAVE_AVX2
extern const LaneKernels lane_kernels_with_avx2;
#endif

const LaneKernels& baseline_lane_kernels()
{
    static constexpr LaneKernels kernels{subtract_product, subtract_transposed, triangle, triangle_transposed,
                                         product_of_eight};
    return kernels;
}

const LaneKernels* avx2_lane_kernels()
{
#ifdef SINEW_HAVE_AVX2
    if (__builtin_cpu_supports("avx2"))
        return &lane_kernels_with_avx2;
#endif
    return nullptr;
}

const LaneKernels& lane_kernels()
{
    static const LaneKernels& kernels = avx2_lane_kernels() ? *avx2_lane_kernels() : baseline_lane_kernels();
    return kernels;
}

} // namespace sinew
