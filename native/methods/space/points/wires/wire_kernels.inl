// SPDX-License-Identifier: GPL-3.0-or-later
// The body of WireKernels, compiled once for each set of instructions.

#include "native/core/simd/lane_math.inl"

#include <cstddef>

namespace sinew {

namespace {

using Wide = Lanes<double>;

constexpr int terms = 16; // of the series below, for angles up to pi

/// The coefficients of a series in a^2: (-1)^k / (2 k + first)!
template <int first>
struct Coefficients
{
    double of[terms];
    constexpr Coefficients() : of()
    {
        double next = 1.0; // of them, without its sign: 1 / first!
        for (int k = 1; k <= first; ++k)
            next /= k;
        for (int k = 0; k < terms; ++k) {
            of[k] = k % 2 ? -next : next;
            next /= (2.0 * k + first + 1.0) * (2.0 * k + first + 2.0);
        }
    }
};

/// The sum of a series. Odd and even terms are summed apart: each sum waits for its own last term alone.
template <int first>
inline Wide series(Wide square)
{
    static constexpr Coefficients<first> coefficients;
    const double* of = coefficients.of;
    const Wide fourth = square * square;
    Wide even = constant(of[terms - 2]), odd = constant(of[terms - 1]);
    for (int k = terms - 4; k >= 0; k -= 2) {
        even = constant(of[k]) + fourth * even;
        odd = constant(of[k + 1]) + fourth * odd;
    }
    return even + square * odd;
}

/// sin(a) / a and (1 - cos(a)) / a^2 for a^2 = square, by their series.
inline void turning(Wide square, Wide& sine, Wide& cosine)
{
    sine = series<1>(square);
    cosine = series<2>(square);
}

void moves(const WireContacts& contacts, const double* table, int first, int blocks, double* out)
{
    for (int block = first; block < first + blocks; ++block, out += 16) {
        const Wide nothing = constant(0.0);
        Wide sum[4] = {nothing, nothing, nothing, nothing}, turn[4] = {nothing, nothing, nothing, nothing};
        for (int stretch = contacts.firsts[block]; stretch < contacts.firsts[block + 1]; ++stretch) {
            const int* const samples = contacts.samples + 4 * static_cast<std::ptrdiff_t>(stretch);
            const double* sample[4];
            for (int lane = 0; lane < 4; ++lane)
                sample[lane] = table + 8 * static_cast<std::ptrdiff_t>(samples[lane]);
            const std::ptrdiff_t begin = contacts.rows[stretch], end = contacts.rows[stretch + 1];
            const double* share = contacts.shares + 4 * begin;
            for (std::ptrdiff_t at = 0; at < 8 * (end - begin); at += 8, share += 4)
                for (int lane = 0; lane < 4; ++lane) {
                    sum[lane] = sum[lane] + share[lane] * load(sample[lane] + at);
                    turn[lane] = turn[lane] + share[lane] * load(sample[lane] + at + 4);
                }
        }
        transpose(sum[0], sum[1], sum[2], sum[3]);
        transpose(turn[0], turn[1], turn[2], turn[3]);
        const double* from = contacts.blocks + 20 * static_cast<std::ptrdiff_t>(block);
        const Wide x = load(from), y = load(from + 4), z = load(from + 8), F = load(from + 12);
        const Wide scale = constant(1.0) + load(from + 16);
        const Wide u = F * turn[0], v = F * turn[1], w = F * turn[2];
        Wide S, C;
        turning(u * u + v * v + w * w, S, C);
        const Wide a = scale * x, b = scale * y, c = scale * z;
        const Wide p = v * c - w * b, q = w * a - u * c, r = u * b - v * a;
        Wide dx = ((a + (S * p + C * (v * r - w * q))) - x) + F * sum[0];
        Wide dy = ((b + (S * q + C * (w * p - u * r))) - y) + F * sum[1];
        Wide dz = ((c + (S * r + C * (u * q - v * p))) - z) + F * sum[2];
        Wide none = constant(0.0);
        transpose(dx, dy, dz, none);
        store(out, dx), store(out + 4, dy), store(out + 8, dz), store(out + 12, none);
    }
}

} // namespace

const WireKernels WireKernels::SINEW_INSTRUCTIONS{sinew::moves};

} // namespace sinew
