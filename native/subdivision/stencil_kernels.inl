// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of StencilKernels, compiled once for each set of instructions.

#include "native/core/simd/lane_types.inl"

namespace {

template <class T>
inline Lanes<T> weighted_point(const int* indices, const T* weights, const T* points, int k)
{
    return weights[k] * load(points + 4 * static_cast<std::size_t>(indices[k]));
}

template <class T>
void rows(const int* offsets, const int* indices, const T* weights, const T* points, int begin, int end,
          T* to)
{
    for (int i = begin; i < end; ++i) {
        // Two sums, so that an addition does not have to wait for the one before it.
        Lanes<T> even = {}, odd = {};
        int k = offsets[i];
        for (; k + 1 < offsets[i + 1]; k += 2) {
            even = even + weighted_point(indices, weights, points, k);
            odd = odd + weighted_point(indices, weights, points, k + 1);
        }
        if (k < offsets[i + 1])
            even = even + weighted_point(indices, weights, points, k);
        const Lanes<T> sum = even + odd;
        T* const row = to + 3 * static_cast<std::size_t>(i);
        if (i + 1 < end) {
            store(row, sum); // the next row overwrites the fourth number
        } else {
            row[0] = sum[0];
            row[1] = sum[1];
            row[2] = sum[2];
        }
    }
}

} // namespace

const sinew::StencilKernels sinew::StencilKernels::SINEW_INSTRUCTIONS{rows<double>, rows<float>};
