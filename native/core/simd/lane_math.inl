// SPDX-License-Identifier: GPL-3.0-or-later
// Angles and logarithms of all lanes at once, for the .inl files of kernels (see lane_types.inl). They
// consist of additions, multiplications, divisions and roots only, so they give the same bits on every
// machine, which the functions of C libraries do not.

#include "native/core/simd/lane_types.inl"

#ifndef __GNUC__
#include <bit>
#include <cstdint>
#endif

namespace {

#ifdef __GNUC__
typedef unsigned long long LaneBits __attribute__((vector_size(8 * lane_count)));

inline LaneBits bits_of(Lanes<double> a) { return (LaneBits)a; }
inline Lanes<double> lanes_of(LaneBits bits) { return (Lanes<double>)bits; }
inline LaneBits same_bits(unsigned long long value) { return LaneBits{} + value; }
#else
struct LaneBits
{
    std::uint64_t lane[4];
};
inline LaneBits bits_of(const Lanes<double>& a)
{
    return {{std::bit_cast<std::uint64_t>(a[0]), std::bit_cast<std::uint64_t>(a[1]),
             std::bit_cast<std::uint64_t>(a[2]), std::bit_cast<std::uint64_t>(a[3])}};
}
inline Lanes<double> lanes_of(const LaneBits& bits)
{
    return {{std::bit_cast<double>(bits.lane[0]), std::bit_cast<double>(bits.lane[1]),
             std::bit_cast<double>(bits.lane[2]), std::bit_cast<double>(bits.lane[3])}};
}
inline LaneBits same_bits(std::uint64_t value) { return {{value, value, value, value}}; }
inline LaneBits operator&(const LaneBits& a, const LaneBits& b)
{
    return {{a.lane[0] & b.lane[0], a.lane[1] & b.lane[1], a.lane[2] & b.lane[2], a.lane[3] & b.lane[3]}};
}
inline LaneBits operator|(const LaneBits& a, const LaneBits& b)
{
    return {{a.lane[0] | b.lane[0], a.lane[1] | b.lane[1], a.lane[2] | b.lane[2], a.lane[3] | b.lane[3]}};
}
inline LaneBits operator>>(const LaneBits& a, int places)
{
    return {{a.lane[0] >> places, a.lane[1] >> places, a.lane[2] >> places, a.lane[3] >> places}};
}
#endif

inline Lanes<double> larger(Lanes<double> a, Lanes<double> b) { return choose(above(a, b), a, b); }
inline Lanes<double> magnitude(Lanes<double> a)
{
    return lanes_of(bits_of(a) & same_bits(0x7fffffffffffffffULL));
}
/// |a| with the sign of b.
inline Lanes<double> signed_as(Lanes<double> a, Lanes<double> b)
{
    return lanes_of((bits_of(a) & same_bits(0x7fffffffffffffffULL)) |
                    (bits_of(b) & same_bits(0x8000000000000000ULL)));
}

/// x = m 2^e with 1 <= m < 2, for positive normal x, where shifted = e + 1023 + 2^52: the difference of two such
/// numbers is that of the exponents.
inline void split(Lanes<double> x, Lanes<double>& m, Lanes<double>& shifted)
{
    const LaneBits bits = bits_of(x);
    m = lanes_of((bits & same_bits(0x000fffffffffffffULL)) | same_bits(0x3ff0000000000000ULL));
    // The bits of the exponent become the last bits of the number 2^52 + exponent.
    shifted = lanes_of((bits >> 52) | same_bits(0x4330000000000000ULL));
}

/// ln(a / b) for positive normal a and b, to 2 units in the last place of 1 + |ln(a / b)|.
inline Lanes<double> log_of_ratio(Lanes<double> a, Lanes<double> b)
{
    Lanes<double> m, n, e, f;
    split(a, m, e);
    split(b, n, f);
    // ln(m / n) = 2 atanh z with |z| <= 1/3. The polynomial interpolates (atanh(z) / z - 1) / z^2 at
    // Chebyshev points.
    const Lanes<double> z = (m - n) / (m + n), u = z * z, u2 = u * u, u4 = u2 * u2;
    const Lanes<double> low = (constant(0.3333333333333333) + constant(0.20000000000007292) * u) +
                              (constant(0.1428571428355438) + constant(0.11111111358713932) * u) * u2;
    const Lanes<double> middle = (constant(0.09090894718066429) + constant(0.07692785032479312) * u) +
                                 (constant(0.06657072104827468) + constant(0.06000536404795356) * u) * u2;
    const Lanes<double> high = constant(0.04400369243072337) + constant(0.08082022805971766) * u;
    const Lanes<double> series = low + (middle + high * u4) * u4;
    // ln 2 is split into two parts, so that the product of the first with the exponent is exact.
    const Lanes<double> k = e - f, twice = z + z;
    return k * constant(6.93147180369123816490e-01) +
           (twice + (twice * (u * series) + k * constant(1.90821492927058770002e-10)));
}

/// An angle as atan(numerator / denominator) + base, where |numerator / denominator| <= tan(pi / 8).
struct ReducedAngle
{
    Lanes<double> numerator, denominator, base;
};

/// The angle atan2(y, |x|) for y >= 0.
inline ReducedAngle reduce(Lanes<double> y, Lanes<double> x)
{
    const Lanes<double> zero = constant(0.0), flat = magnitude(x);
    const auto oblique = above(y, constant(0.41421356237309503) * flat);
    const auto steep = above(y, constant(2.4142135623730951) * flat);
    return {
        choose(steep, zero - flat, choose(oblique, y - flat, y)),
        choose(steep, y, choose(oblique, y + flat, flat)),
        choose(steep, constant(1.5707963267948966), choose(oblique, constant(0.78539816339744831), zero))};
}

/// The angle in [0, pi] whose reduced tangent is t. Its cosine has the sign of x.
inline Lanes<double> angle_of(const ReducedAngle& reduced, Lanes<double> t, Lanes<double> x)
{
    // The polynomial interpolates (atan(t) / t - 1) / t^2 at Chebyshev points.
    const Lanes<double> u = t * t, u2 = u * u, u4 = u2 * u2;
    const Lanes<double> low = (constant(-0.3333333333333333) + constant(0.1999999999999552) * u) +
                              (constant(-0.14285714284666542) + constant(0.11111111015256361) * u) * u2;
    const Lanes<double> middle = (constant(-0.09090904578123903) + constant(0.07692183190826087) * u) +
                                 (constant(-0.06664511447381948) + constant(0.0585814891280221) * u) * u2;
    const Lanes<double> high = (constant(-0.0508544973794026) + constant(0.03923165829558719) * u) +
                               constant(-0.01917688711906226) * u2;
    const Lanes<double> series = low + (middle + high * u4) * u4;
    const Lanes<double> angle = reduced.base + (t + t * (u * series));
    return choose(above(constant(0.0), x), constant(3.1415926535897931) - angle, angle);
}

/// atan2(y, x) for y >= 0, to 2 units in the last place; 0 where both are 0.
inline Lanes<double> angle_between(Lanes<double> y, Lanes<double> x)
{
    const ReducedAngle reduced = reduce(y, x);
    const Lanes<double> denominator = larger(reduced.denominator, constant(1e-300));
    return angle_of(reduced, reduced.numerator / denominator, x);
}

/// atan2(y, x) / y for y > 0, with a single division, to 4 units in the last place.
inline Lanes<double> angle_over_sine(Lanes<double> y, Lanes<double> x)
{
    const ReducedAngle reduced = reduce(y, x);
    const Lanes<double> inverse = constant(1.0) / (reduced.denominator * y);
    const Lanes<double> t = reduced.numerator * (y * inverse);
    return angle_of(reduced, t, x) * (reduced.denominator * inverse);
}

} // namespace
