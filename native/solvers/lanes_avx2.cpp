// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled with AVX2, and run only where the processor has it.
#include "native/solvers/lanes.h"

#include "native/solvers/lanes.inl"

namespace sinew {

extern const LaneKernels<double> lane_kernels_of_doubles_with_avx2;
extern const LaneKernels<float> lane_kernels_of_floats_with_avx2;
const LaneKernels<double> lane_kernels_of_doubles_with_avx2{forward_lanes, backward_lanes, product_of_eight};
const LaneKernels<float> lane_kernels_of_floats_with_avx2{forward_lanes, backward_lanes, product_of_eight};

} // namespace sinew
