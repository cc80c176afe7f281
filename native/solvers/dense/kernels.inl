// SPDX-License-Identifier: GPL-3.0-or-later
// The body of DenseKernels, compiled once for each set of instructions.

#include "native/core/simd/lane_types.inl"

#include <cstddef>
#include <type_traits>

namespace {

/// Strips of a product, side by side.
template <int height, int strips>
inline void add_strips(const double* a, std::ptrdiff_t stride_a, std::ptrdiff_t step_a, int inner,
                       const double* b, double* const* c)
{
    constexpr int per_strip = 8 / lane_count, parts = strips * per_strip;
    const auto at = [&](int part) {
        return 8 * inner * (part / per_strip) + lane_count * (part % per_strip);
    };
    Lanes<double> sum[height][parts];
    for (int r = 0; r < height; ++r)
        for (int part = 0; part < parts; ++part)
            sum[r][part] = load(c[r] + lane_count * part);
    for (int k = 0; k < inner; ++k, a += step_a, b += 8)
        for (int r = 0; r < height; ++r)
            for (int part = 0; part < parts; ++part)
                sum[r][part] = sum[r][part] + a[r * stride_a] * load(b + at(part));
    for (int r = 0; r < height; ++r)
        for (int part = 0; part < parts; ++part)
            store(c[r] + lane_count * part, sum[r][part]);
}

void add_product(const double* a, int stride_a, int step_a, int rows, int inner, const double* b, int strips,
                 double* c, int stride_c, const int* place)
{
    constexpr int high = lane_count, wide = lane_count / 4; // so that all sums are in registers
    const auto line = [&](int r) { return c + static_cast<std::ptrdiff_t>(place ? place[r] : r) * stride_c; };
    const auto add = [&]<int some>(int s, std::integral_constant<int, some>) {
        int r = 0;
        for (; r + high <= rows; r += high) {
            double* lines[high];
            for (int k = 0; k < high; ++k)
                lines[k] = line(r + k) + 8 * s;
            add_strips<high, some>(a + static_cast<std::ptrdiff_t>(r) * stride_a, stride_a, step_a, inner, b,
                                   lines);
        }
        for (; r < rows; ++r) {
            double* const one[] = {line(r) + 8 * s};
            add_strips<1, some>(a + static_cast<std::ptrdiff_t>(r) * stride_a, stride_a, step_a, inner, b,
                                one);
        }
        b += 8 * some * inner;
    };
    int s = 0;
    for (; s + wide <= strips; s += wide)
        add(s, std::integral_constant<int, wide>{});
    for (; s < strips; ++s)
        add(s, std::integral_constant<int, 1>{});
}

/// Rows [first, first + height) of one strip, when those before are done.
template <int height>
inline void substitute_strip(const double* u, std::ptrdiff_t stride_u, int first, double* x,
                             std::ptrdiff_t stride_x)
{
    constexpr int parts = 8 / lane_count;
    Lanes<double> sum[height][parts];
    double* const own = x + first * stride_x;
    for (int r = 0; r < height; ++r)
        for (int part = 0; part < parts; ++part)
            sum[r][part] = load(own + r * stride_x + lane_count * part);
    const double* factors = u + first;
    for (int k = 0; k < first; ++k, factors += stride_u, x += stride_x)
        for (int part = 0; part < parts; ++part) {
            const Lanes<double> known = load(x + lane_count * part);
            for (int r = 0; r < height; ++r)
                sum[r][part] = sum[r][part] - factors[r] * known;
        }
    for (int r = 0; r < height; ++r, factors += stride_u) {
        const double scale = 1.0 / factors[r];
        for (int part = 0; part < parts; ++part) {
            sum[r][part] = scale * sum[r][part];
            store(own + r * stride_x + lane_count * part, sum[r][part]);
            for (int later = r + 1; later < height; ++later)
                sum[later][part] = sum[later][part] - factors[later] * sum[r][part];
        }
    }
}

void substitute(const double* u, int stride_u, int rows, double* x, int stride_x, int strips)
{
    for (int s = 0; s < strips; ++s, x += 8) {
        constexpr int high = lane_count;
        int r = 0;
        for (; r + high <= rows; r += high)
            substitute_strip<high>(u, stride_u, r, x, stride_x);
        for (; r < rows; ++r)
            substitute_strip<1>(u, stride_u, r, x, stride_x);
    }
}

} // namespace

const sinew::DenseKernels sinew::DenseKernels::SINEW_INSTRUCTIONS{::add_product, ::substitute};
