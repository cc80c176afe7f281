// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/subdivision/stencils.h"

#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/subdivision/stencil_kernels.h"

#include <memory>
#include <utility>

namespace sinew {

namespace {

constexpr int grain = 4096;

template <class T, class Rows>
void apply_rows(const SparseRows& matrix, const T* weights, const T* points, T* to, Rows rows)
{
    // The points are few compared with the rows. They are copied to four numbers each, so that one load reads
    // a point without reading past the end of the last one.
    const int count = static_cast<int>(matrix.cols());
    const auto padded = std::make_unique_for_overwrite<T[]>(4 * static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        for (int k = 0; k < 3; ++k)
            padded[4 * i + k] = points[3 * i + k];
        padded[4 * i + 3] = 0;
    }
    parallel_chunks(static_cast<int>(matrix.rows()), grain, [&](int begin, int end) {
        rows(matrix.outerIndexPtr(), matrix.innerIndexPtr(), weights, padded.get(), begin, end, to);
    });
}

} // namespace

Stencils::Stencils(SparseRows&& matrix)
{
    matrix_.swap(matrix); // the move constructor of Eigen's sparse matrices would copy
    matrix_.makeCompressed();
    single_.assign(matrix_.valuePtr(), matrix_.valuePtr() + matrix_.nonZeros());
}

void Stencils::apply(const double* points, double* to) const
{
    apply_rows(matrix_, matrix_.valuePtr(), points, to, widest_kernels<StencilKernels>().in_double);
}

void Stencils::apply(const float* points, float* to) const
{
    apply_rows(matrix_, single_.data(), points, to, widest_kernels<StencilKernels>().in_float);
}

} // namespace sinew
