// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled with AVX2, and run only where the processor has it.
#include "native/space/cage/cage_kernels.h"

#include <cstddef>

#include "native/space/cage/cage_kernels.inl"
#include "native/space/cage/cage_products.inl"

namespace sinew {

extern const CageKernels cage_kernels_with_avx2;
const CageKernels cage_kernels_with_avx2{
    lane_count,           mean_value,      green,          arc_integrals,
    beyond_planes,        product<double>, product<float>, sparse_product<double>,
    sparse_product<float>};

} // namespace sinew
