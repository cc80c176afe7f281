// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/dense_kernels.h"

#include "native/core/processor.h"

#include <cmath>
#include <cstddef>

#include "native/solvers/dense_kernels.inl"

namespace sinew {

#ifdef SINEW_HAVE_AVX2
extern const DenseKernels dense_kernels_with_avx2, dense_kernels_with_avx512;
#endif

const DenseKernels& baseline_dense_kernels()
{
    static constexpr DenseKernels kernels{add_product};
    return kernels;
}

const DenseKernels* avx2_dense_kernels()
{
#ifdef SINEW_HAVE_AVX2
    if (__builtin_cpu_supports("avx2"))
        return &dense_kernels_with_avx2;
#endif
    return nullptr;
}

const DenseKernels* avx512_dense_kernels()
{
#ifdef SINEW_HAVE_AVX2
    if (has_avx512())
        return &dense_kernels_with_avx512;
#endif
    return nullptr;
}

const DenseKernels& dense_kernels()
{
    static const DenseKernels& kernels =
        widest(baseline_dense_kernels(), avx2_dense_kernels(), avx512_dense_kernels());
    return kernels;
}

} // namespace sinew
