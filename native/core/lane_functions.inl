// SPDX-License-Identifier: GPL-3.0-or-later
// Functions of four numbers side by side, for the .inl files of kernels. Every compiler does the same
// operations in the same order, so that kernels for different instructions agree to the last bit.

#include "native/core/lane_types.inl"

#if defined(__AVX__) || defined(__SSE2__)
#include <immintrin.h>
#endif
#ifndef __GNUC__
#include <bit>
#include <cstdint>
#endif

namespace {

/// sqrt(a); root() of lane_types.inl asks the C library about each negative number.
inline Lanes<double> square_root(Lanes<double> a)
{
#if defined(__GNUC__) && defined(__AVX__)
    return (Lanes<double>)_mm256_sqrt_pd((__m256d)a);
#elif defined(__GNUC__) && defined(__SSE2__)
    union
    {
        Lanes<double> lanes;
        __m128d half[2];
    } both = {a};
    both.half[0] = _mm_sqrt_pd(both.half[0]);
    both.half[1] = _mm_sqrt_pd(both.half[1]);
    return both.lanes;
#else
    return root(a);
#endif
}

inline Lanes<double> larger(Lanes<double> a, Lanes<double> b) { return choose(above(a, b), a, b); }
inline Lanes<double> magnitude(Lanes<double> a)
{
    return choose(above(a, constant(0.0)), a, constant(0.0) - a);
}

/// Coefficients of a polynomial, the constant one first.
template <int count>
inline Lanes<double> polynomial(const double (&coefficients)[count], Lanes<double> x)
{
    Lanes<double> sum = constant(coefficients[count - 1]);
    for (int k = count - 2; k >= 0; --k)
        sum = sum * x + constant(coefficients[k]);
    return sum;
}

/// a = fraction 2^exponent with 1 <= fraction < 2; a must be a normal positive number.
inline Lanes<double> fraction_of(Lanes<double> a, Lanes<double>& exponent)
{
#ifdef __GNUC__
    typedef long long Longs __attribute__((vector_size(32)));
    const Longs bits = (Longs)a;
    exponent = (Lanes<double>)((bits >> 52) | 0x4330000000000000LL) - constant(0x1p52 + 1023);
    return (Lanes<double>)((bits & 0x000fffffffffffffLL) | 0x3ff0000000000000LL);
#else
    Lanes<double> fraction;
    for (int k = 0; k < 4; ++k) {
        const auto bits = std::bit_cast<std::uint64_t>(a[k]);
        exponent[k] = static_cast<double>(bits >> 52) - 1023;
        fraction[k] = std::bit_cast<double>((bits & 0x000fffffffffffffULL) | 0x3ff0000000000000ULL);
    }
    return fraction;
#endif
}

/// log(a / b) of normal positive numbers, off by some 1e-16.
inline Lanes<double> log_of_ratio(Lanes<double> a, Lanes<double> b)
{
    // 2 atanh(sqrt x) / sqrt x as far as ((sqrt 2 - 1) / (sqrt 2 + 1))^2, to 2e-18
    static const double series[] = {1.9999999999999999977, .66666666666667645659, .39999999999302337687,
                                    .28571428760641776463, .22222197056715726446, .18183631680790656865,
                                    .15312528133331411644, .14809710517865929808};
    const Lanes<double> steep = constant(1.41421356237309504880), one = constant(1.0), two = constant(2.0);
    Lanes<double> power_a, power_b;
    Lanes<double> m = fraction_of(a, power_a);
    const Lanes<double> n = fraction_of(b, power_b);
    Lanes<double> power = power_a - power_b;
    const auto high = above(m, steep * n), low = above(n, steep * m);
    power = choose(high, power + one, choose(low, power - one, power));
    m = choose(high, constant(0.5) * m, choose(low, two * m, m));
    const Lanes<double> z = (m - n) / (m + n);
    return power * constant(.69314718055994530942) + z * polynomial(series, z * z);
}

/// The angle of (x, y), y >= 0, in [0, pi], off by some 1e-16; that of (0, 0) is 0.
inline Lanes<double> angle_of(Lanes<double> y, Lanes<double> x)
{
    // atan(sqrt x) / sqrt x as far as tan(pi / 8)^2, to 4e-17
    static const double series[] = {.99999999999999996532,   -.33333333333328438567, .19999999998855109191,
                                    -.14285714180976391032,  .11111106180452865292,  -.090907730747368609872,
                                    .076899534952989416602,  -.06640233921673450529, .056883491809884171738,
                                    -.043480520833406280112, .0211353715364984151};
    const Lanes<double> zero = constant(0.0);
    const Lanes<double> across = magnitude(x);
    const auto steep = above(y, across);
    Lanes<double> low = choose(steep, across, y);
    Lanes<double> high = larger(choose(steep, y, across), constant(1e-300));
    const auto folded = above(low, constant(.41421356237309504880) * high);
    const Lanes<double> difference = low - high, sum = low + high;
    const Lanes<double> t = choose(folded, difference, low) / choose(folded, sum, high);
    Lanes<double> angle =
        choose(folded, constant(.78539816339744830962), zero) + t * polynomial(series, t * t);
    angle = choose(steep, constant(1.57079632679489661923) - angle, angle);
    return choose(above(zero, x), constant(3.14159265358979323846) - angle, angle);
}

} // namespace
