// SPDX-License-Identifier: GPL-3.0-or-later
// Vectors of four numbers, or of eight where SINEW_EIGHT_LANES is defined; one number of a vector is a lane.
// For the .inl files of kernels, which are compiled once for each set of instructions. Everything is in an
// unnamed namespace, so that no function compiled for wider instructions is shared with other code.
#pragma once
#ifndef __GNUC__
#include <cmath>
#elif defined(__SSE2__)
#include <immintrin.h>
#endif

namespace {

#ifdef SINEW_EIGHT_LANES
constexpr int lane_count = 8;
#else
constexpr int lane_count = 4;
#endif

#ifdef __GNUC__
template <class T, int count>
struct LanesOf;
template <int count>
struct LanesOf<double, count>
{
    typedef double type __attribute__((vector_size(8 * count)));
};
template <int count>
struct LanesOf<float, count>
{
    typedef float type __attribute__((vector_size(4 * count)));
};
template <class T>
using Lanes = typename LanesOf<T, lane_count>::type;
using FourLanes = LanesOf<double, 4>::type;

/// A vector from numbers, which are aligned for a number and not for vectors. (A type of vectors could say so,
/// but Clang forgets its alignment where it passes through a template.)
template <class Vector, class T>
inline Vector load_as(const T* from)
{
    Vector vector;
    __builtin_memcpy(&vector, from, sizeof vector);
    return vector;
}
template <class T>
inline Lanes<T> load(const T* from)
{
    return load_as<Lanes<T>>(from);
}
template <class T, class Vector>
inline void store(T* to, Vector lanes)
{
    __builtin_memcpy(to, &lanes, sizeof lanes);
}

#ifndef SINEW_EIGHT_LANES
/// A vector with lane k in all four lanes.
template <int k, class T>
inline T splat(T lanes)
{
    return __builtin_shufflevector(lanes, lanes, k, k, k, k);
}
/// (x, y, z, w) -> (y, z, x, w)
template <class T>
inline T turned(T lanes)
{
    return __builtin_shufflevector(lanes, lanes, 1, 2, 0, 3);
}
template <class Mask>
inline bool all(Mask mask)
{
    return mask[0] && mask[1] && mask[2] && mask[3];
}
#endif
/// Lane k of x, y and z becomes the first, second and third number of the k-th row.
inline void load_columns(const double* a, const double* b, const double* c, const double* d, FourLanes& x,
                         FourLanes& y, FourLanes& z)
{
    using Pair = LanesOf<double, 2>::type;
    const auto pairs = [](const double* p, const double* q) {
        return __builtin_shufflevector(load_as<Pair>(p), load_as<Pair>(q), 0, 1, 2, 3);
    };
    const FourLanes ac = pairs(a, c), bd = pairs(b, d), ac_end = pairs(a + 1, c + 1),
                    bd_end = pairs(b + 1, d + 1);
    x = __builtin_shufflevector(ac, bd, 0, 4, 2, 6);
    y = __builtin_shufflevector(ac, bd, 1, 5, 3, 7);
    z = __builtin_shufflevector(ac_end, bd_end, 1, 5, 3, 7);
}
/// The coordinates of as many points (x, y, z), one after the other, as there are lanes.
inline void load_points(const double* points, Lanes<double>& x, Lanes<double>& y, Lanes<double>& z)
{
    const auto four = [](const double* p, FourLanes& u, FourLanes& v, FourLanes& w) {
        load_columns(p, p + 3, p + 6, p + 9, u, v, w);
    };
#ifdef SINEW_EIGHT_LANES
    FourLanes low[3], high[3];
    four(points, low[0], low[1], low[2]);
    four(points + 12, high[0], high[1], high[2]);
    x = __builtin_shufflevector(low[0], high[0], 0, 1, 2, 3, 4, 5, 6, 7);
    y = __builtin_shufflevector(low[1], high[1], 0, 1, 2, 3, 4, 5, 6, 7);
    z = __builtin_shufflevector(low[2], high[2], 0, 1, 2, 3, 4, 5, 6, 7);
#else
    four(points, x, y, z);
#endif
}
/// The reverse of load_points().
inline void store_points(double* points, Lanes<double> x, Lanes<double> y, Lanes<double> z)
{
    const auto four = [](double* to, FourLanes u, FourLanes v, FourLanes w) {
        const FourLanes uv = __builtin_shufflevector(u, v, 0, 4, 1, 5),
                        vw = __builtin_shufflevector(v, w, 1, 5, 2, 6),
                        wu = __builtin_shufflevector(w, u, 2, 7, 3, 3);
        store(to, __builtin_shufflevector(uv, w, 0, 1, 4, 2));
        store(to + 4, __builtin_shufflevector(vw, u, 0, 1, 6, 2));
        store(to + 8, __builtin_shufflevector(wu, v, 0, 1, 7, 2));
    };
#ifdef SINEW_EIGHT_LANES
    const auto low = [](Lanes<double> a) { return __builtin_shufflevector(a, a, 0, 1, 2, 3); };
    const auto high = [](Lanes<double> a) { return __builtin_shufflevector(a, a, 4, 5, 6, 7); };
    four(points, low(x), low(y), low(z));
    four(points + 12, high(x), high(y), high(z));
#else
    four(points, x, y, z);
#endif
}
/// Lane k of the n-th vector becomes lane n of the k-th.
inline void transpose(FourLanes& a, FourLanes& b, FourLanes& c, FourLanes& d)
{
    const FourLanes ab02 = __builtin_shufflevector(a, b, 0, 4, 2, 6);
    const FourLanes ab13 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const FourLanes cd02 = __builtin_shufflevector(c, d, 0, 4, 2, 6);
    const FourLanes cd13 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    a = __builtin_shufflevector(ab02, cd02, 0, 1, 4, 5);
    b = __builtin_shufflevector(ab13, cd13, 0, 1, 4, 5);
    c = __builtin_shufflevector(ab02, cd02, 2, 3, 6, 7);
    d = __builtin_shufflevector(ab13, cd13, 2, 3, 6, 7);
}
/// Stores lane k of a, b, c and d as the k-th row of four numbers.
inline void store_rows(double* rows, int stride, Lanes<double> a, Lanes<double> b, Lanes<double> c,
                       Lanes<double> d)
{
    const auto four = [&](double* to, FourLanes p, FourLanes q, FourLanes r, FourLanes s) {
        transpose(p, q, r, s);
        const FourLanes lines[4] = {p, q, r, s};
        for (int k = 0; k < 4; ++k)
            store(to + k * stride, lines[k]);
    };
#ifdef SINEW_EIGHT_LANES
    const auto low = [](Lanes<double> x) { return __builtin_shufflevector(x, x, 0, 1, 2, 3); };
    const auto high = [](Lanes<double> x) { return __builtin_shufflevector(x, x, 4, 5, 6, 7); };
    four(rows, low(a), low(b), low(c), low(d));
    four(rows + 4 * stride, high(a), high(b), high(c), high(d));
#else
    four(rows, a, b, c, d);
#endif
}
inline Lanes<double> constant(double value) { return value - Lanes<double>{}; }
inline Lanes<double> widened(Lanes<double> a) { return a; }
inline Lanes<double> widened(Lanes<float> a) { return __builtin_convertvector(a, Lanes<double>); }
inline Lanes<float> narrowed(Lanes<double> a) { return __builtin_convertvector(a, Lanes<float>); }
inline Lanes<double> root(Lanes<double> a) // std::sqrt of each lane would check whether to set errno
{
#if defined(SINEW_EIGHT_LANES)
    return _mm512_maskz_sqrt_pd(255, a); // GCC warns of undefined lanes in the version without a mask
#elif defined(__AVX__)
    return _mm256_sqrt_pd(a);
#elif defined(__SSE2__)
    const __m128d low = _mm_sqrt_pd(__builtin_shufflevector(a, a, 0, 1));
    const __m128d high = _mm_sqrt_pd(__builtin_shufflevector(a, a, 2, 3));
    return __builtin_shufflevector(low, high, 0, 1, 2, 3);
#else
    return Lanes<double>{__builtin_sqrt(a[0]), __builtin_sqrt(a[1]), __builtin_sqrt(a[2]),
                         __builtin_sqrt(a[3])};
#endif
}
/// A mask of the lanes in which a > b.
inline auto above(Lanes<double> a, Lanes<double> b) { return a > b; }
template <class Mask>
inline Lanes<double> choose(Mask mask, Lanes<double> yes, Lanes<double> no)
{
    return mask ? yes : no;
}
/// An integer whose bit k is lane k of a mask of doubles.
template <class Mask>
inline int mask_bits(Mask mask)
{
#if defined(SINEW_EIGHT_LANES)
    return _mm512_movepi64_mask((__m512i)mask);
#elif defined(__AVX__)
    return _mm256_movemask_pd((Lanes<double>)mask);
#elif defined(__SSE2__)
    const Lanes<double> lanes = (Lanes<double>)mask;
    return _mm_movemask_pd(__builtin_shufflevector(lanes, lanes, 0, 1)) |
           _mm_movemask_pd(__builtin_shufflevector(lanes, lanes, 2, 3)) << 2;
#else
    return (mask[0] ? 1 : 0) | (mask[1] ? 2 : 0) | (mask[2] ? 4 : 0) | (mask[3] ? 8 : 0);
#endif
}
#else
template <class T>
struct Lanes
{
    T lane[4];
    T operator[](int k) const { return lane[k]; }
    T& operator[](int k) { return lane[k]; }
};
template <class T>
inline Lanes<T> load(const T* from)
{
    return {{from[0], from[1], from[2], from[3]}};
}
template <class T>
inline void store(T* to, const Lanes<T>& lanes)
{
    for (int k = 0; k < 4; ++k)
        to[k] = lanes.lane[k];
}
template <class T>
inline Lanes<T> operator*(T factor, const Lanes<T>& a)
{
    return {{factor * a[0], factor * a[1], factor * a[2], factor * a[3]}};
}
template <class T>
inline Lanes<T> operator*(const Lanes<T>& a, const Lanes<T>& b)
{
    return {{a[0] * b[0], a[1] * b[1], a[2] * b[2], a[3] * b[3]}};
}
template <class T>
inline Lanes<T> operator/(const Lanes<T>& a, const Lanes<T>& b)
{
    return {{a[0] / b[0], a[1] / b[1], a[2] / b[2], a[3] / b[3]}};
}
template <class T>
inline Lanes<T> operator+(const Lanes<T>& a, const Lanes<T>& b)
{
    return {{a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]}};
}
template <class T>
inline Lanes<T> operator-(const Lanes<T>& a, const Lanes<T>& b)
{
    return {{a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]}};
}
struct LaneMask
{
    bool lane[4];
    bool operator[](int k) const { return lane[k]; }
};
inline LaneMask operator&(const LaneMask& a, const LaneMask& b)
{
    return {{a[0] && b[0], a[1] && b[1], a[2] && b[2], a[3] && b[3]}};
}
inline LaneMask operator|(const LaneMask& a, const LaneMask& b)
{
    return {{a[0] || b[0], a[1] || b[1], a[2] || b[2], a[3] || b[3]}};
}
template <int k, class T>
inline Lanes<T> splat(const Lanes<T>& a)
{
    return {{a[k], a[k], a[k], a[k]}};
}
template <class T>
inline Lanes<T> turned(const Lanes<T>& a)
{
    return {{a[1], a[2], a[0], a[3]}};
}
inline void load_columns(const double* a, const double* b, const double* c, const double* d, Lanes<double>& x,
                         Lanes<double>& y, Lanes<double>& z)
{
    x = {{a[0], b[0], c[0], d[0]}};
    y = {{a[1], b[1], c[1], d[1]}};
    z = {{a[2], b[2], c[2], d[2]}};
}
inline void load_points(const double* points, Lanes<double>& x, Lanes<double>& y, Lanes<double>& z)
{
    load_columns(points, points + 3, points + 6, points + 9, x, y, z);
}
inline void store_points(double* points, const Lanes<double>& x, const Lanes<double>& y,
                         const Lanes<double>& z)
{
    for (int k = 0; k < 4; ++k) {
        points[3 * k] = x[k];
        points[3 * k + 1] = y[k];
        points[3 * k + 2] = z[k];
    }
}
inline void transpose(Lanes<double>& a, Lanes<double>& b, Lanes<double>& c, Lanes<double>& d)
{
    const Lanes<double> m[4] = {a, b, c, d};
    a = {{m[0][0], m[1][0], m[2][0], m[3][0]}};
    b = {{m[0][1], m[1][1], m[2][1], m[3][1]}};
    c = {{m[0][2], m[1][2], m[2][2], m[3][2]}};
    d = {{m[0][3], m[1][3], m[2][3], m[3][3]}};
}
inline void store_rows(double* rows, int stride, Lanes<double> a, Lanes<double> b, Lanes<double> c,
                       Lanes<double> d)
{
    for (int k = 0; k < 4; ++k)
        store(rows + k * stride, Lanes<double>{{a[k], b[k], c[k], d[k]}});
}
inline Lanes<double> constant(double value) { return {{value, value, value, value}}; }
inline Lanes<double> widened(const Lanes<double>& a) { return a; }
inline Lanes<double> widened(const Lanes<float>& a) { return {{a[0], a[1], a[2], a[3]}}; }
inline Lanes<float> narrowed(const Lanes<double>& a)
{
    return {{static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(a[2]),
             static_cast<float>(a[3])}};
}
inline Lanes<double> root(const Lanes<double>& a)
{
    return {{std::sqrt(a[0]), std::sqrt(a[1]), std::sqrt(a[2]), std::sqrt(a[3])}};
}
inline LaneMask above(const Lanes<double>& a, const Lanes<double>& b)
{
    return {{a[0] > b[0], a[1] > b[1], a[2] > b[2], a[3] > b[3]}};
}
inline Lanes<double> choose(const LaneMask& mask, const Lanes<double>& yes, const Lanes<double>& no)
{
    Lanes<double> result;
    for (int k = 0; k < 4; ++k)
        result[k] = mask[k] ? yes[k] : no[k];
    return result;
}
inline bool all(const LaneMask& mask) { return mask[0] && mask[1] && mask[2] && mask[3]; }
inline int mask_bits(const LaneMask& mask)
{
    return (mask[0] ? 1 : 0) | (mask[1] ? 2 : 0) | (mask[2] ? 4 : 0) | (mask[3] ? 8 : 0);
}
#endif

} // namespace
