// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of ArapKernels, compiled once for each instruction set; see core/lane_types.inl.

#include "native/operators/rotation_fit.inl"

namespace {

using sinew::ArapView;
using sinew::ArapWing;
using L = Lanes<double>;

struct Columns
{
    L x, y, z;
};

inline Columns columns(const double* matrices, int i)
{
    const double* const m = matrices + 12 * static_cast<std::size_t>(i);
    return {load(m), load(m + 4), load(m + 8)};
}

inline void store(double* matrices, int i, const Columns& m)
{
    double* const to = matrices + 12 * static_cast<std::size_t>(i);
    store(to, m.x);
    store(to + 4, m.y);
    store(to + 8, m.z);
}

inline L point(const double* points, int i) { return load(points + 4 * static_cast<std::size_t>(i)); }

inline L product(const Columns& m, L v) { return m.x * splat<0>(v) + m.y * splat<1>(v) + m.z * splat<2>(v); }

/// m += a b^T
inline void add_outer(Columns& m, L a, L b)
{
    m.x = m.x + a * splat<0>(b);
    m.y = m.y + a * splat<1>(b);
    m.z = m.z + a * splat<2>(b);
}

inline L cross(L a, L b) { return turned(a * turned(b) - turned(a) * b); }

inline double sum(L a) { return a[0] + a[1] + a[2]; }

inline L squares(const Columns& m) { return m.x * m.x + m.y * m.y + m.z * m.z; }

inline Columns scaled(double factor, const Columns& m) { return {factor * m.x, factor * m.y, factor * m.z}; }

inline void add(Columns& m, double factor, const Columns& n)
{
    m.x = m.x + factor * n.x;
    m.y = m.y + factor * n.y;
    m.z = m.z + factor * n.z;
}

/// Neighbours come in no order that a processor could foresee, but most lie ahead not far.
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

void covariances(const ArapView& view, int begin, int end, double* S)
{
    for (int i = begin; i < end; ++i) {
        fetch<4>(view.base, i);
        fetch<4>(view.points, i);
        Columns s{constant(0.0), constant(0.0), constant(0.0)};
        const L p = point(view.base, i), q = point(view.points, i);
        if (view.wing_offsets) {
            for (int k = view.wing_offsets[i]; k < view.wing_offsets[i + 1]; ++k) {
                const ArapWing& t = view.wings[k];
                const L p_b = point(view.base, t.b), p_c = point(view.base, t.c);
                const L q_b = point(view.points, t.b), q_c = point(view.points, t.c);
                add_outer(s, q - q_b, t.to_b * (p - p_b));
                add_outer(s, q - q_c, t.to_c * (p - p_c));
                add_outer(s, q_b - q_c, t.across * (p_b - p_c));
            }
        } else {
            for (int a = view.offsets[i]; a < view.offsets[i + 1]; ++a) {
                const int j = view.neighbours[a];
                add_outer(s, q - point(view.points, j), view.weights[a] * (p - point(view.base, j)));
            }
        }
        store(S, i - begin, scaled(view.rigidity[i], s));
    }
}

void add_neighbours(const ArapView& view, const double* R, int begin, int end, double* S)
{
    for (int i = begin; i < end; ++i) {
        fetch<12>(R, i);
        Columns s = columns(S, i - begin);
        for (int a = view.offsets[i]; a < view.offsets[i + 1]; ++a) {
            const int j = view.neighbours[a];
            const double w = view.smoothing * view.weights[a] * (view.rigidity[i] + view.rigidity[j]);
            add(s, w, columns(R, j));
        }
        store(S, i - begin, s);
    }
}

void torques(const double* S, const double* R, int count, double* t)
{
    for (int i = 0; i < count; ++i) {
        const Columns s = columns(S, i), r = columns(R, i);
        const L torque = cross(r.x, s.x) + cross(r.y, s.y) + cross(r.z, s.z);
        for (int k = 0; k < 3; ++k)
            t[3 * static_cast<std::size_t>(i) + k] = torque[k];
    }
}

void turn(const double* omega, const double* R, int count, double* to)
{
    for (int i = 0; i < count; ++i) {
        const double* const w = omega + 3 * static_cast<std::size_t>(i);
        double x = 0.5 * w[0], y = 0.5 * w[1], z = 0.5 * w[2];
        double square = x * x + y * y + z * z;
        if (square > 0.25) {
            const double factor = 0.5 / std::sqrt(square);
            x *= factor, y *= factor, z *= factor;
            square = 0.25;
        }
        // (1 + |h|^2) turn = (1 - |h|^2) I + 2 h h^T + 2 [h]x, h = omega / 2
        const double d = 1.0 - square, unit = 1.0 / (1.0 + square);
        const Columns turn{L{d + 2 * x * x, 2 * (x * y + z), 2 * (x * z - y), 0.0},
                           L{2 * (x * y - z), d + 2 * y * y, 2 * (y * z + x), 0.0},
                           L{2 * (x * z + y), 2 * (y * z - x), d + 2 * z * z, 0.0}};
        const Columns r = scaled(unit, columns(R, i));
        store(to, i, {product(turn, r.x), product(turn, r.y), product(turn, r.z)});
    }
}

/// Entries row-major of the four matrices from `i` on; those beyond `count` repeat the last one.
inline void gather(const double* matrices, int i, int count, L* entries)
{
    for (int column = 0; column < 3; ++column) {
        L m[4];
        for (int k = 0; k < 4; ++k) {
            const int row = i + k < count ? i + k : count - 1;
            m[k] = load(matrices + 12 * static_cast<std::size_t>(row) + 4 * column);
        }
        transpose(m[0], m[1], m[2], m[3]);
        for (int row = 0; row < 3; ++row)
            entries[3 * row + column] = m[row];
    }
}

void fit(const double* S, const double* R, double tie, int count, double* to, bool* safe)
{
    constexpr int groups = 4; // of four matrices, stepping together: no one waits for another's division
    for (int first = 0; first < count; first += 4 * groups) {
        FourFits fits[groups];
        const int present = count - first < 4 * groups ? (count - first + 3) / 4 : groups;
        for (int g = 0; g < present; ++g) {
            L s[9], r[9];
            gather(S, first + 4 * g, count, s);
            gather(R, first + 4 * g, count, r);
            L square = s[0] * s[0], trace = s[0] * r[0];
            for (int k = 1; k < 9; ++k) {
                square = square + s[k] * s[k];
                trace = trace + s[k] * r[k];
            }
            const L share = constant(tie) * root(square);
            for (int k = 0; k < 9; ++k)
                s[k] = s[k] + share * r[k];
            fits[g].begin(s, trace + constant(3.0) * share);
        }
        bool done = false;
        for (int step = 0; step < most_newton_steps && !done; ++step) {
            done = true;
            for (int g = 0; g < present; ++g)
                fits[g].step();
            for (int g = 0; g < present; ++g)
                done = done && fits[g].done();
        }
        for (int g = 0; g < present; ++g) {
            L r[9];
            const auto found = fits[g].finish(r);
            const int i = first + 4 * g;
            for (int column = 0; column < 3; ++column) {
                L m[4]{r[column], r[3 + column], r[6 + column], constant(0.0)};
                transpose(m[0], m[1], m[2], m[3]);
                for (int k = 0; k < 4 && i + k < count; ++k)
                    store(to + 12 * static_cast<std::size_t>(i + k) + 4 * column, m[k]);
            }
            for (int k = 0; k < 4 && i + k < count; ++k)
                safe[i + k] = found[k];
        }
    }
}

/// What a node's cell adds to energy and forces where its edges to the other corners are rims.
inline void add_wings(const ArapView& view, const double* R, int i, L& cell, L& force)
{
    const L p = point(view.base, i), q = point(view.points, i);
    const Columns r = columns(R, i);
    const Columns weighted = scaled(view.rigidity[i], r);
    for (int k = view.wing_offsets[i]; k < view.wing_offsets[i + 1]; ++k) {
        const ArapWing& t = view.wings[k];
        const L e_b = p - point(view.base, t.b), e_c = p - point(view.base, t.c);
        const L d_b = q - point(view.points, t.b), d_c = q - point(view.points, t.c);
        const L b = d_b - product(r, e_b), c = d_c - product(r, e_c);
        const L across = (d_c - d_b) - product(r, e_c - e_b);
        cell = cell + t.to_b * (b * b) + t.to_c * (c * c) + t.across * (across * across);
        Columns all = weighted;
        add(all, view.rigidity[t.b], columns(R, t.b));
        add(all, view.rigidity[t.c], columns(R, t.c));
        const double rigidity = view.rigidity[i] + view.rigidity[t.b] + view.rigidity[t.c];
        force = force + (t.to_b / 3.0) * (rigidity * d_b - product(all, e_b)) +
                (t.to_c / 3.0) * (rigidity * d_c - product(all, e_c));
    }
}

template <bool rims, bool smooth>
double energy_of(const ArapView& view, const double* R, int begin, int end, double* gradient)
{
    L total = constant(0.0);
    for (int i = begin; i < end; ++i) {
        if (view.idle[i])
            continue;
        fetch<4>(view.base, i);
        fetch<4>(view.points, i);
        fetch<12>(R, i);
        const L p = point(view.base, i), q = point(view.points, i);
        const Columns r = columns(R, i);
        const double own_rigidity = view.rigidity[i];
        L cell = constant(0.0), bend = constant(0.0), force = constant(0.0);
        if constexpr (!rims || smooth)
            for (int a = view.offsets[i]; a < view.offsets[i + 1]; ++a) {
                const int j = view.neighbours[a];
                const double w = view.weights[a], other_rigidity = view.rigidity[j];
                const Columns other = columns(R, j);
                if constexpr (!rims) {
                    const L e = p - point(view.base, j), d = q - point(view.points, j);
                    const L x = splat<0>(e), y = splat<1>(e), z = splat<2>(e);
                    const L own = d - (r.x * x + r.y * y + r.z * z);
                    const L others = d - (other.x * x + other.y * y + other.z * z);
                    cell = cell + w * (own * own);
                    force = force + ((w * own_rigidity) * own + (w * other_rigidity) * others);
                }
                if constexpr (smooth)
                    bend = bend + (w * (own_rigidity + other_rigidity)) *
                                      squares({r.x - other.x, r.y - other.y, r.z - other.z});
            }
        if constexpr (rims)
            add_wings(view, R, i, cell, force);
        else
            force = 0.5 * force;
        total = total + (own_rigidity * cell + (0.5 * view.smoothing) * bend);
        if (view.place[i] >= 0)
            for (int k = 0; k < 3; ++k)
                gradient[3 * static_cast<std::size_t>(view.place[i]) + k] = force[k];
    }
    return sum(total);
}

double energy(const ArapView& view, const double* R, int begin, int end, double* gradient)
{
    const auto body = view.wing_offsets
                          ? (view.smoothing > 0 ? energy_of<true, true> : energy_of<true, false>)
                          : (view.smoothing > 0 ? energy_of<false, true> : energy_of<false, false>);
    return body(view, R, begin, end, gradient);
}

} // namespace
