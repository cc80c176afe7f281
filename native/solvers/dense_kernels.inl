// SPDX-License-Identifier: GPL-3.0-or-later
// The body of DenseKernels, compiled once for each instruction set.

#include "native/core/lane_types.inl"

namespace {

template <int height>
inline void add_strip(const double* a, int stride_a, int inner, const double* b, double* const* c)
{
    Lanes<double> left[height], right[height];
    for (int r = 0; r < height; ++r) {
        left[r] = load(c[r]);
        right[r] = load(c[r] + 4);
    }
    for (int k = 0; k < inner; ++k, b += 8) {
        const Lanes<double> first = load(b), second = load(b + 4);
        for (int r = 0; r < height; ++r) {
            const double factor = a[r * stride_a + k];
            left[r] = left[r] + factor * first;
            right[r] = right[r] + factor * second;
        }
    }
    for (int r = 0; r < height; ++r) {
        store(c[r], left[r]);
        store(c[r] + 4, right[r]);
    }
}

void add_product(const double* a, int stride_a, int rows, int inner, const double* b, int strips, double* c,
                 int stride_c, const int* place)
{
    const auto line = [&](int r) { return c + static_cast<std::ptrdiff_t>(place ? place[r] : r) * stride_c; };
    for (int s = 0; s < strips; ++s, b += 8 * inner) {
        int r = 0;
        for (; r + 4 <= rows; r += 4) {
            double* const four[] = {line(r) + 8 * s, line(r + 1) + 8 * s, line(r + 2) + 8 * s,
                                    line(r + 3) + 8 * s};
            add_strip<4>(a + static_cast<std::ptrdiff_t>(r) * stride_a, stride_a, inner, b, four);
        }
        for (; r < rows; ++r) {
            double* const one[] = {line(r) + 8 * s};
            add_strip<1>(a + static_cast<std::ptrdiff_t>(r) * stride_a, stride_a, inner, b, one);
        }
    }
}

} // namespace
