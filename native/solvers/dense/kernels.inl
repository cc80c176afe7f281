// SPDX-License-Identifier: GPL-3.0-or-later
// The body of DenseKernels, compiled once for each set of instructions.

#include "native/core/simd/lane_types.inl"

namespace {

template <int height>
inline void add_strip(const double* a, int stride_a, int inner, const double* b, double* const* c)
{
    constexpr int parts = 8 / lane_count;
    Lanes<double> sum[height][parts];
    for (int r = 0; r < height; ++r)
        for (int part = 0; part < parts; ++part)
            sum[r][part] = load(c[r] + lane_count * part);
    for (int k = 0; k < inner; ++k, b += 8)
        for (int r = 0; r < height; ++r)
            for (int part = 0; part < parts; ++part)
                sum[r][part] = sum[r][part] + a[r * stride_a + k] * load(b + lane_count * part);
    for (int r = 0; r < height; ++r)
        for (int part = 0; part < parts; ++part)
            store(c[r] + lane_count * part, sum[r][part]);
}

void add_product(const double* a, int stride_a, int rows, int inner, const double* b, int strips, double* c,
                 int stride_c, const int* place)
{
    const auto line = [&](int r) { return c + static_cast<std::ptrdiff_t>(place ? place[r] : r) * stride_c; };
    for (int s = 0; s < strips; ++s, b += 8 * inner) {
        constexpr int high = lane_count; // so that all sums are in registers
        int r = 0;
        for (; r + high <= rows; r += high) {
            double* lines[high];
            for (int k = 0; k < high; ++k)
                lines[k] = line(r + k) + 8 * s;
            add_strip<high>(a + static_cast<std::ptrdiff_t>(r) * stride_a, stride_a, inner, b, lines);
        }
        for (; r < rows; ++r) {
            double* const one[] = {line(r) + 8 * s};
            add_strip<1>(a + static_cast<std::ptrdiff_t>(r) * stride_a, stride_a, inner, b, one);
        }
    }
}

} // namespace

const sinew::DenseKernels sinew::DenseKernels::SINEW_INSTRUCTIONS{::add_product};
