// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of ArapKernels, compiled once for each set of instructions; see lane_types.inl.

#include "native/local_global/arap/columns.inl"
#include "native/operators/fits/rotation_fit.inl"

namespace {

using sinew::GraphChunk;
using sinew::GraphTriangle;
using sinew::GraphView;

/// The place of a node's sum. All nodes of other chunks share one place, behind those of this chunk.
inline int slot(const GraphChunk& chunk, int node)
{
    const unsigned at = static_cast<unsigned>(node - chunk.begin);
    const unsigned count = static_cast<unsigned>(chunk.end - chunk.begin);
    return static_cast<int>(at < count ? at : count);
}

void covariances(const GraphView& view, const GraphChunk& chunk, double* S)
{
    const Columns zero{constant(0.0), constant(0.0), constant(0.0)};
    const int count = chunk.end - chunk.begin;
    for (int i = 0; i <= count; ++i) // the last place is for nodes of other chunks
        store(S, i, zero);
    if (view.rims) {
        for (int k = chunk.first_triangle; k < chunk.last_triangle; ++k) {
            const GraphTriangle& t = view.triangles[k];
            const int a = t.corner[0], b = t.corner[1], c = t.corner[2];
            const L p = point(view.base, a), q = point(view.points, a);
            const L e_b = point(view.base, b) - p, e_c = point(view.base, c) - p;
            const L d_b = point(view.points, b) - q, d_c = point(view.points, c) - q;
            const L rim = t.across[0] * (e_c - e_b);
            const Columns all = outer(d_b, t.across[2] * e_b - rim) + outer(d_c, t.across[1] * e_c + rim);
            for (int corner : t.corner) {
                const int at = slot(chunk, corner);
                store(S, at, columns(S, at) + all);
            }
        }
        for (int i = 0; i < count; ++i)
            store(S, i, scaled(view.rigidity[chunk.begin + i], columns(S, i)));
        return;
    }
    for (int i = chunk.begin; i < chunk.end; ++i) {
        fetch<3>(view.base, i);
        fetch<3>(view.points, i);
        Columns s = columns(S, i - chunk.begin);
        const L p = point(view.base, i), q = point(view.points, i);
        const int* const edges = view.edges + 2 * static_cast<std::size_t>(i);
        int a = edges[0];
        for (; a < edges[1]; ++a) {
            const int j = view.ends[a];
            const Columns both =
                outer(q - point(view.points, j), view.weights[a] * (p - point(view.base, j)));
            s = s + both;
            store(S, j - chunk.begin, columns(S, j - chunk.begin) + both);
        }
        for (; a < edges[2]; ++a) {
            const int j = view.ends[a];
            s = s + outer(q - point(view.points, j), view.weights[a] * (p - point(view.base, j)));
        }
        store(S, i - chunk.begin, scaled(view.rigidity[i], s));
    }
}

void add_neighbours(const GraphView& view, const GraphChunk& chunk, const double* R, double* S)
{
    for (int i = chunk.begin; i < chunk.end; ++i) {
        fetch<9>(R, i);
        Columns s = columns(S, i - chunk.begin);
        const Columns r = packed(R, i);
        const int* const edges = view.edges + 2 * static_cast<std::size_t>(i);
        const auto share = [&](int a) {
            return view.smoothing * view.weights[a] * (view.rigidity[i] + view.rigidity[view.ends[a]]);
        };
        int a = edges[0];
        for (; a < edges[1]; ++a) {
            const int j = view.ends[a];
            const double w = share(a);
            s = s + scaled(w, packed(R, j));
            store(S, j - chunk.begin, columns(S, j - chunk.begin) + scaled(w, r));
        }
        for (; a < edges[2]; ++a)
            s = s + scaled(share(a), packed(R, view.ends[a]));
        store(S, i - chunk.begin, s);
    }
}

void torques(const GraphView& view, const GraphChunk& chunk, const double* S, const double* R, double* t)
{
    L sums[sinew::graph_chunk]; // of rotated cross products, which are opposite at the two ends of an edge
    for (int i = chunk.begin; i < chunk.end; ++i)
        sums[i - chunk.begin] = constant(0.0);
    for (int i = chunk.begin; i < chunk.end; ++i) {
        fetch<9>(R, i);
        const Columns r = packed(R, i), s = columns(S, i - chunk.begin);
        const Columns turned_r{turned(r.x), turned(r.y), turned(r.z)};
        const auto cross_with = [&](const Columns& m) {
            return (r.x * turned(m.x) - turned_r.x * m.x) + (r.y * turned(m.y) - turned_r.y * m.y) +
                   (r.z * turned(m.z) - turned_r.z * m.z);
        };
        L sum = sums[i - chunk.begin] + cross_with(s);
        const int* const edges = view.edges + 2 * static_cast<std::size_t>(i);
        for (int a = edges[0]; a < edges[2]; ++a) {
            const int j = view.ends[a];
            const double w = view.smoothing * view.weights[a] * (view.rigidity[i] + view.rigidity[j]);
            const L pull = w * cross_with(packed(R, j));
            sum = sum + pull;
            if (a < edges[1])
                sums[j - chunk.begin] = sums[j - chunk.begin] - pull;
        }
        store_three(t + 3 * static_cast<std::size_t>(i - chunk.begin), turned(sum));
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
        const Columns r = scaled(unit, packed(R, i));
        store_packed(to, i, {product(turn, r.x), product(turn, r.y), product(turn, r.z)});
    }
}

/// The entries of four matrices from matrix i on, row-major, one matrix per lane. `numbers` has their
/// columns, of `rows` numbers each; where there are fewer than four matrices before `count`, the last one is
/// repeated.
template <int rows>
inline void gather(const double* matrices, int i, int count, L* entries)
{
    for (int column = 0; column < 3; ++column) {
        L m[4];
        for (int k = 0; k < 4; ++k) {
            const int node = i + k < count ? i + k : count - 1;
            m[k] = load(matrices + rows * (3 * static_cast<std::size_t>(node) + column));
        }
        transpose(m[0], m[1], m[2], m[3]);
        for (int row = 0; row < 3; ++row)
            entries[3 * row + column] = m[row];
    }
}

void fit(const double* S, const double* R, double tie, int count, double* to, bool* safe)
{
    constexpr int groups = 4; // of four matrices; they are stepped in turn, as a step waits for a division
    for (int first = 0; first < count; first += 4 * groups) {
        FourFits fits[groups];
        const int present = count - first < 4 * groups ? (count - first + 3) / 4 : groups;
        for (int g = 0; g < present; ++g) {
            L s[9], r[9];
            gather<4>(S, first + 4 * g, count, s);
            gather<3>(R, first + 4 * g, count, r);
            L trace = s[0] * r[0];
            for (int k = 1; k < 9; ++k)
                trace = trace + s[k] * r[k];
            if (tie > 0) {
                L square = s[0] * s[0];
                for (int k = 1; k < 9; ++k)
                    square = square + s[k] * s[k];
                const L share = constant(tie) * root(square);
                for (int k = 0; k < 9; ++k)
                    s[k] = s[k] + share * r[k];
                trace = trace + constant(3.0) * share;
            }
            fits[g].begin(s, trace);
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
            L m[3][4];
            for (int column = 0; column < 3; ++column) {
                for (int row = 0; row < 3; ++row)
                    m[column][row] = r[3 * row + column];
                m[column][3] = constant(0.0);
                transpose(m[column][0], m[column][1], m[column][2], m[column][3]);
            }
            for (int k = 0; k < 4 && i + k < count; ++k) {
                safe[i + k] = found[k];
                if (found[k])
                    store_packed(to, i + k, {m[0][k], m[1][k], m[2][k]});
            }
        }
    }
}

/// The energy of cells of triangles. Adds the gradient to `forces`, four numbers per node.
L triangle_energy(const GraphView& view, const GraphChunk& chunk, const double* R, double* forces)
{
    L total = constant(0.0);
    for (int k = chunk.first_triangle; k < chunk.last_triangle; ++k) {
        const GraphTriangle& t = view.triangles[k];
        const int a = t.corner[0], b = t.corner[1], c = t.corner[2];
        const L p = point(view.base, a), q = point(view.points, a);
        const L e_b = point(view.base, b) - p, e_c = point(view.base, c) - p;
        const L d_b = point(view.points, b) - q, d_c = point(view.points, c) - q;
        const L b_x = splat<0>(e_b), b_y = splat<1>(e_b), b_z = splat<2>(e_b);
        const L c_x = splat<0>(e_c), c_y = splat<1>(e_c), c_z = splat<2>(e_c);
        L at_b = constant(0.0), at_c = constant(0.0);
        int slots[3];
        for (int corner = 0; corner < 3; ++corner) {
            const int node = t.corner[corner];
            const double rigidity = view.rigidity[node];
            const Columns r = packed(R, node);
            const L to_b = d_b - (r.x * b_x + r.y * b_y + r.z * b_z);
            const L to_c = d_c - (r.x * c_x + r.y * c_y + r.z * c_z);
            const L rim = to_c - to_b;
            slots[corner] = slot(chunk, node);
            const double own = slots[corner] < chunk.end - chunk.begin ? rigidity : 0.0;
            total = total + own * (t.across[2] * (to_b * to_b) + t.across[1] * (to_c * to_c) +
                                   t.across[0] * (rim * rim));
            at_b = at_b + rigidity * to_b;
            at_c = at_c + rigidity * to_c;
        }
        const L rim = (t.across[0] / 3.0) * (at_c - at_b);
        const L force_b = (t.across[2] / 3.0) * at_b - rim, force_c = (t.across[1] / 3.0) * at_c + rim;
        const auto add = [&](int corner, L force) {
            double* const to = forces + 4 * slots[corner];
            store(to, load(to) + force);
        };
        add(0, constant(0.0) - (force_b + force_c));
        add(1, force_b);
        add(2, force_c);
    }
    return total;
}

/// The energy of edges: of stretching if `cells` consist of edges, and of bending if `smooth`. Adds the
/// gradient to `forces`, four numbers per node.
template <bool cells, bool smooth>
L edge_energy(const GraphView& view, const GraphChunk& chunk, const double* R, double* forces)
{
    L total = constant(0.0), bend = constant(0.0);
    for (int i = chunk.begin; i < chunk.end; ++i) {
        fetch<3>(view.base, i);
        fetch<3>(view.points, i);
        fetch<9>(R, i);
        const L p = point(view.base, i), q = point(view.points, i);
        const Columns r = packed(R, i);
        const double rigidity = view.rigidity[i];
        double* const force_at = forces + 4 * (i - chunk.begin);
        L force = load(force_at);
        const int* const edges = view.edges + 2 * static_cast<std::size_t>(i);
        const auto edge = [&](int a, bool within) {
            const int j = view.ends[a];
            const double w = view.weights[a], other_rigidity = view.rigidity[j];
            const Columns other = packed(R, j);
            if constexpr (cells) {
                const L e = p - point(view.base, j), d = q - point(view.points, j);
                const L x = splat<0>(e), y = splat<1>(e), z = splat<2>(e);
                const L own = d - (r.x * x + r.y * y + r.z * z);
                const L others = d - (other.x * x + other.y * y + other.z * z);
                const L own_force = (w * rigidity) * own, others_force = (w * other_rigidity) * others;
                const L pull = own_force + others_force;
                force = force + pull;
                total = total + own_force * own;
                if (within) {
                    total = total + others_force * others;
                    double* const to = forces + 4 * (j - chunk.begin);
                    store(to, load(to) - pull);
                }
            }
            if constexpr (smooth)
                bend = bend + ((within ? 2.0 : 1.0) * w * (rigidity + other_rigidity)) *
                                  squares({r.x - other.x, r.y - other.y, r.z - other.z});
        };
        int a = edges[0];
        for (; a < edges[1]; ++a)
            edge(a, true);
        for (; a < edges[2]; ++a)
            edge(a, false);
        if constexpr (cells)
            store(force_at, 0.5 * force);
    }
    return total + (0.5 * view.smoothing) * bend;
}

double energy(const GraphView& view, const GraphChunk& chunk, const double* R, double* gradient)
{
    double forces[4 * (sinew::graph_chunk + 1)];
    const int count = chunk.end - chunk.begin;
    for (int i = 0; i <= count; ++i)
        store(forces + 4 * i, constant(0.0));
    L total = constant(0.0);
    if (view.rims) {
        total = triangle_energy(view, chunk, R, forces);
        if (view.smoothing > 0)
            total = total + edge_energy<false, true>(view, chunk, R, forces);
    } else {
        total = view.smoothing > 0 ? edge_energy<true, true>(view, chunk, R, forces)
                                   : edge_energy<true, false>(view, chunk, R, forces);
    }
    const int free = view.free < chunk.end ? view.free - chunk.begin : count;
    for (int i = 0; i < free; ++i)
        store_three(gradient + 3 * (static_cast<std::size_t>(chunk.begin) + i), load(forces + 4 * i));
    return sum(total);
}

} // namespace

const sinew::ArapKernels sinew::ArapKernels::SINEW_INSTRUCTIONS{
    ::covariances, ::add_neighbours, ::torques, ::turn, ::fit, ::energy};
