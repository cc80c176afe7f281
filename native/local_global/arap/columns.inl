// SPDX-License-Identifier: GPL-3.0-or-later
// Points and 3x3 matrices in four lanes, for the .inl files of kernels in this room (see lane_types.inl).

#include "native/core/simd/lane_types.inl"

namespace {

using L = Lanes<double>;

struct Columns
{
    L x, y, z;
};

/// Stores the first three lanes only; the number behind them is not touched.
inline void store_three(double* to, L a)
{
#ifdef __GNUC__
    store(to, __builtin_shufflevector(a, a, 0, 1));
    to[2] = a[2];
#else
    for (int k = 0; k < 3; ++k)
        to[k] = a[k];
#endif
}

/// Loads the columns of matrix i, of nine numbers. The fourth lanes hold the numbers that follow.
inline Columns packed(const double* matrices, int i)
{
    const double* const m = matrices + 9 * static_cast<std::size_t>(i);
    return {load(m), load(m + 3), load(m + 6)};
}

inline void store_packed(double* matrices, int i, const Columns& m)
{
    double* const to = matrices + 9 * static_cast<std::size_t>(i);
    store_three(to, m.x);
    store_three(to + 3, m.y);
    store_three(to + 6, m.z);
}

/// Loads covariance i.
inline Columns columns(const double* S, int i)
{
    const double* const m = S + sinew::covariance_columns * static_cast<std::size_t>(i);
    return {load(m), load(m + 4), load(m + 8)};
}

inline void store(double* S, int i, const Columns& m)
{
    double* const to = S + sinew::covariance_columns * static_cast<std::size_t>(i);
    store(to, m.x);
    store(to + 4, m.y);
    store(to + 8, m.z);
}

inline L point(const double* points, int i) { return load(points + 3 * static_cast<std::size_t>(i)); }

inline L product(const Columns& m, L v) { return m.x * splat<0>(v) + m.y * splat<1>(v) + m.z * splat<2>(v); }

/// a b^T
inline Columns outer(L a, L b) { return {a * splat<0>(b), a * splat<1>(b), a * splat<2>(b)}; }

inline Columns operator+(const Columns& a, const Columns& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }

inline double sum(L a) { return a[0] + a[1] + a[2]; }

inline L squares(const Columns& m) { return m.x * m.x + m.y * m.y + m.z * m.z; }

inline Columns scaled(double factor, const Columns& m) { return {factor * m.x, factor * m.y, factor * m.z}; }

/// Fetches the numbers of a later node into the cache. A processor cannot foresee which neighbours will be
/// read, but most of them lie not far ahead.
template <int per_node>
inline void fetch(const double* numbers, int i)
{
#ifdef __GNUC__
    constexpr int nodes_ahead = 256;
    const double* const at = numbers + per_node * (static_cast<std::size_t>(i) + nodes_ahead);
    for (int k = 0; k < per_node; k += 8)
        __builtin_prefetch(at + k);
#endif
}

} // namespace
