// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/lanes.h"

#include "native/solvers/lanes.inl"

#include <type_traits>

namespace sinew {

#ifdef SINEW_HAVE_AVX2
extern const LaneKernels<double> lane_kernels_of_doubles_with_avx2;
extern const LaneKernels<float> lane_kernels_of_floats_with_avx2;
#endif

template <class T>
const LaneKernels<T>& baseline_lane_kernels()
{
    static constexpr LaneKernels<T> kernels{forward_lanes, backward_lanes, product_of_eight};
    return kernels;
}

template <class T>
const LaneKernels<T>* avx2_lane_kernels()
{
#ifdef SINEW_HAVE_AVX2
    if (__builtin_cpu_supports("avx2")) {
        if constexpr (std::is_same_v<T, double>)
            return &lane_kernels_of_doubles_with_avx2;
        else
            return &lane_kernels_of_floats_with_avx2;
    }
#endif
    return nullptr;
}

template <class T>
const LaneKernels<T>& lane_kernels()
{
    static const LaneKernels<T>& kernels =
        avx2_lane_kernels<T>() ? *avx2_lane_kernels<T>() : baseline_lane_kernels<T>();
    return kernels;
}

template const LaneKernels<double>& baseline_lane_kernels();
template const LaneKernels<float>& baseline_lane_kernels();
template const LaneKernels<double>* avx2_lane_kernels();
template const LaneKernels<float>* avx2_lane_kernels();
template const LaneKernels<double>& lane_kernels();
template const LaneKernels<float>& lane_kernels();

} // namespace sinew
