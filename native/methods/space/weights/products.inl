// SPDX-License-Identifier: GPL-3.0-or-later
// The body of ProductKernels, compiled once for each set of instructions.

#include "native/core/simd/lane_types.inl"

namespace {

/// sums (rows, 4) = weights * factors (k, 4). Row i of the weights is [offsets[i], offsets[i + 1]).
template <class T>
void sparse_product(const T* weights, const int* columns, const int* offsets, int rows, const T* factors,
                    T* sums)
{
    for (int i = 0; i < rows; ++i) {
        Lanes<T> even = T(0) * load(factors), odd = even;
        int k = offsets[i];
        for (; k + 1 < offsets[i + 1]; k += 2) {
            even = even + weights[k] * load(factors + 4 * static_cast<std::size_t>(columns[k]));
            odd = odd + weights[k + 1] * load(factors + 4 * static_cast<std::size_t>(columns[k + 1]));
        }
        if (k < offsets[i + 1])
            even = even + weights[k] * load(factors + 4 * static_cast<std::size_t>(columns[k]));
        store(sums + 4 * static_cast<std::size_t>(i), even + odd);
    }
}

#ifdef __GNUC__

/// Two vectors of points and three columns are six sums that grow side by side.
template <class T>
void product(const T* block, int columns, const T* factors, T* sums)
{
    using Wide = typename LanesOf<T, 32 / sizeof(T)>::type;
    constexpr int width = 32 / sizeof(T);
    Wide total[6] = {};
    while (columns > 0) {
        // The columns are summed in groups, and then the groups are summed, which rounds less than one long
        // sum.
        const int some = columns < 64 ? columns : 64;
        Wide sum[6] = {};
        for (int c = 0; c < some; ++c, block += 2 * width, factors += 3) {
            const Wide b[2] = {load_as<Wide>(block), load_as<Wide>(block + width)};
            for (int k = 0; k < 6; ++k)
                sum[k] = sum[k] + factors[k / 2] * b[k % 2];
        }
        for (int k = 0; k < 6; ++k)
            total[k] = total[k] + sum[k];
        columns -= some;
    }
    for (int k = 0; k < 6; ++k)
        store(sums + width * k, total[k]);
}
#else
template <class T>
void product(const T* block, int columns, const T* factors, T* sums)
{
    constexpr int points = 64 / sizeof(T);
    T total[3 * points] = {};
    while (columns > 0) {
        const int some = columns < 64 ? columns : 64;
        T sum[3 * points] = {};
        for (int c = 0; c < some; ++c, block += points, factors += 3)
            for (int k = 0; k < 3 * points; ++k)
                sum[k] = sum[k] + factors[k / points] * block[k % points];
        for (int k = 0; k < 3 * points; ++k)
            total[k] = total[k] + sum[k];
        columns -= some;
    }
    for (int k = 0; k < 3 * points; ++k)
        sums[k] = total[k];
}
#endif

} // namespace

const sinew::ProductKernels sinew::ProductKernels::SINEW_INSTRUCTIONS{
    product<double>, product<float>, sparse_product<double>, sparse_product<float>};
