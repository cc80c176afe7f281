// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of MlsKernels, compiled once for each set of instructions. One lane is one point.

#include "native/operators/fits/rotation_fit.inl"

namespace {

using sinew::MlsFrame;
using sinew::MlsMaps;
using sinew::MlsSums;
using L = Lanes<double>;

/// Below this share of the cube of its trace, a determinant is rounding.
constexpr double least_determinant = 1e-13;

/// Of the largest eigenvalue. All fits take as many, so that a point moves the same beside any others; these
/// are enough wherever the fit is safe: 11 halve the distance to a root of slope 1e-3, and 6 square it.
constexpr int newton_steps = 17;

struct Sums
{
    L total, places[3], moves[3], spread[6], together[3][3];
};

template <class T>
inline void add_points(const MlsFrame& frame, const T* weights, const L* v, Sums& s)
{
    const double* from = frame.points;
    for (int j = 0; j < frame.point_count; ++j, from += 6, weights += 4) {
        const L w = widened(load(weights));
        const L p[3] = {constant(from[0]) - v[0], constant(from[1]) - v[1], constant(from[2]) - v[2]};
        const L wp[3] = {w * p[0], w * p[1], w * p[2]};
        s.total = s.total + w;
        int k = 0;
        for (int a = 0; a < 3; ++a) {
            s.places[a] = s.places[a] + wp[a];
            s.moves[a] = s.moves[a] + w * constant(from[3 + a]);
            for (int b = a; b < 3; ++b, ++k)
                s.spread[k] = s.spread[k] + wp[a] * p[b];
            for (int b = 0; b < 3; ++b)
                s.together[a][b] = s.together[a][b] + constant(from[3 + a]) * wp[b];
        }
    }
}

template <class T>
inline void add_maps(const MlsFrame& frame, const T* weights, const L* v, Sums& s)
{
    constexpr int at[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}}; // entries of a symmetric matrix
    const double* map = frame.maps;
    for (int j = 0; j < frame.map_count; ++j, map += 12, weights += 40) {
        const L w = widened(load(weights));
        L wp[3], wpp[6];
        for (int a = 0; a < 3; ++a)
            wp[a] = widened(load(weights + 4 + 4 * a));
        for (int k = 0; k < 6; ++k)
            wpp[k] = widened(load(weights + 16 + 4 * k));
        s.total = s.total + w;
        for (int a = 0; a < 3; ++a)
            s.places[a] = s.places[a] + wp[a];
        for (int k = 0; k < 6; ++k)
            s.spread[k] = s.spread[k] + wpp[k];
        for (int a = 0; a < 3; ++a) {
            const double* const B = map + 4 * a;
            const L at_v =
                constant(B[0]) * v[0] + constant(B[1]) * v[1] + constant(B[2]) * v[2] + constant(B[3]);
            s.moves[a] =
                s.moves[a] +
                (w * at_v + (constant(B[0]) * wp[0] + constant(B[1]) * wp[1] + constant(B[2]) * wp[2]));
            for (int b = 0; b < 3; ++b)
                s.together[a][b] = s.together[a][b] + (at_v * wp[b] + (constant(B[0]) * wpp[at[0][b]] +
                                                                       constant(B[1]) * wpp[at[1][b]] +
                                                                       constant(B[2]) * wpp[at[2][b]]));
        }
    }
}

/// M - 1 for the sums; which lanes are safe.
inline int linear_part(MlsMaps kind, const Sums& s, L (&M)[3][3])
{
    const L one = constant(1.0), trace = s.spread[0] + s.spread[3] + s.spread[5];
    constexpr int at[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    if (kind == MlsMaps::affine) {
        const L &xx = s.spread[0], &xy = s.spread[1], &xz = s.spread[2], &yy = s.spread[3], &yz = s.spread[4],
                &zz = s.spread[5];
        const L c[6] = {yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy,
                        xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy};
        const L det = xx * c[0] + xy * c[1] + xz * c[2];
        const auto sure = above(det, constant(least_determinant) * trace * trace * trace);
        const auto centre = above(constant(1e-300), trace); // on a point: any map does
        const L inverse = one / choose(sure, det, one);
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) {
                const L entry = (s.together[a][0] * c[at[0][b]] + s.together[a][1] * c[at[1][b]] +
                                 s.together[a][2] * c[at[2][b]]) *
                                inverse;
                M[a][b] = choose(sure, entry, constant(0.0));
            }
        return mask_bits(sure | centre);
    }
    L S[9], R[9];
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
            S[3 * a + b] = s.spread[at[a][b]] + s.together[a][b];
    FourFits fits;
    fits.begin(S, constant(0.0));
    for (int step = 0; step < newton_steps; ++step)
        fits.step();
    const int safe = mask_bits(fits.finish(R) | above(constant(1e-300), trace));
    L scale = one;
    if (kind == MlsMaps::similarity) {
        L along = constant(0.0);
        for (int k = 0; k < 9; ++k)
            along = along + R[k] * S[k];
        const auto spread = above(trace, constant(1e-300));
        scale = choose(spread, along / choose(spread, trace, one), one);
    }
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
            M[a][b] = scale * R[3 * a + b] - (a == b ? one : constant(0.0));
    return safe;
}

template <class T>
int move(const MlsFrame& frame, const T* weights, const double* places, MlsSums& sums, double* moves)
{
    const L zero = constant(0.0);
    L v[3];
    load_columns(places, places + 3, places + 6, places + 9, v[0], v[1], v[2]);
    Sums s;
    s.total = zero;
    for (int a = 0; a < 3; ++a) {
        s.places[a] = zero;
        s.moves[a] = zero;
        for (int b = 0; b < 3; ++b)
            s.together[a][b] = zero;
    }
    for (int k = 0; k < 6; ++k)
        s.spread[k] = zero;
    add_points(frame, weights, v, s);
    add_maps(frame, weights + 4 * static_cast<std::ptrdiff_t>(frame.point_count), v, s);

    const L inverse = constant(1.0) / s.total;
    int k = 0;
    for (int a = 0; a < 3; ++a) {
        for (int b = a; b < 3; ++b, ++k)
            s.spread[k] = s.spread[k] - s.places[a] * s.places[b] * inverse;
        for (int b = 0; b < 3; ++b)
            s.together[a][b] = s.together[a][b] - s.moves[a] * s.places[b] * inverse;
    }
    L M[3][3];
    const int safe = linear_part(frame.kind, s, M);
    L moved[3];
    for (int a = 0; a < 3; ++a)
        moved[a] =
            (s.moves[a] - (M[a][0] * s.places[0] + M[a][1] * s.places[1] + M[a][2] * s.places[2])) * inverse;
    for (int lane = 0; lane < 4; ++lane)
        for (int a = 0; a < 3; ++a)
            moves[3 * lane + a] = moved[a][lane];
    if (safe != 15) {
        store(sums.total, s.total);
        for (int a = 0; a < 3; ++a) {
            store(sums.places[a], s.places[a]);
            store(sums.moves[a], s.moves[a]);
            for (int b = 0; b < 3; ++b)
                store(sums.together[a][b], s.together[a][b]);
        }
        for (int i = 0; i < 6; ++i)
            store(sums.spread[i], s.spread[i]);
    }
    return safe;
}

} // namespace

const sinew::MlsKernels sinew::MlsKernels::SINEW_INSTRUCTIONS{::move<float>, ::move<double>};
