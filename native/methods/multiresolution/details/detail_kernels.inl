// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of DetailKernels, compiled once for each set of instructions. One lane is one triangle.

#include "native/core/simd/lane_types.inl"
#include "native/methods/multiresolution/details/detail_kernels.h"

namespace {

using L = Lanes<double>;

struct Vectors
{
    L x, y, z;
};

inline Vectors operator-(const Vectors& a, const Vectors& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vectors operator+(const Vectors& a, const Vectors& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vectors operator*(double s, const Vectors& a)
{
    const L l = constant(s);
    return {l * a.x, l * a.y, l * a.z};
}
inline Vectors operator*(const L& s, const Vectors& a) { return {s * a.x, s * a.y, s * a.z}; }
inline L dot(const Vectors& a, const Vectors& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vectors cross(const Vectors& a, const Vectors& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Three numbers at the same place in each of four rows.
inline Vectors vectors(const double* const* rows, int at)
{
    Vectors v;
    load_columns(rows[0] + at, rows[1] + at, rows[2] + at, rows[3] + at, v.x, v.y, v.z);
    return v;
}

/// The first number of each row of nine, and where lanes that are not needed go.
struct Rows
{
    double* to[4];
    double unused[9];

    Rows(double* found, int begin, int count)
    {
        for (int lane = 0; lane < 4; ++lane)
            to[lane] = begin + lane < count ? found + 9 * static_cast<long long>(begin + lane) : unused;
    }

    void store(const Vectors& a, const Vectors& b, const Vectors& c)
    {
        double rows[4][8];
        store_rows(rows[0], 8, a.x, a.y, a.z, b.x);
        store_rows(rows[0] + 4, 8, b.y, b.z, c.x, c.y);
        for (int lane = 0; lane < 4; ++lane) {
            for (int k = 0; k < 8; ++k)
                to[lane][k] = rows[lane][k];
            to[lane][8] = c.z[lane];
        }
    }
};

/// The points at the corners of four triangles.
struct Corners
{
    Vectors at[3];

    Corners(const double* points, const int* triangles, int begin, int count)
    {
        for (int corner = 0; corner < 3; ++corner) {
            const double* rows[4];
            for (int lane = 0; lane < 4; ++lane) {
                const int t = begin + lane < count ? begin + lane : count - 1; // the last one fills up
                rows[lane] = points + 3 * static_cast<long long>(triangles[3 * t + corner]);
            }
            at[corner] = vectors(rows, 0);
        }
    }
};

void maps(const double* duals, const double* points, const int* triangles, int count, double* found)
{
    for (int begin = 0; begin < count; begin += 4) {
        const double* dual[4];
        for (int lane = 0; lane < 4; ++lane)
            dual[lane] = duals + 9 * static_cast<long long>(begin + lane < count ? begin + lane : count - 1);
        const Corners p(points, triangles, begin, count);
        const Vectors f1 = p.at[1] - p.at[0], f2 = p.at[2] - p.at[0], N = cross(f1, f2);
        const L square = dot(N, N);
        const L scale = choose(above(square, constant(0.0)), constant(1.0) / root(square), constant(0.0));
        const Vectors n{N.x * scale, N.y * scale, N.z * scale},
            first = vectors(dual, 0), second = vectors(dual, 3), normal = vectors(dual, 6);
        const auto entry = [](const L& f1_r, const L& first_c, const L& f2_r, const L& second_c, const L& n_r,
                              const L& normal_c) {
            return f1_r * first_c + f2_r * second_c + n_r * normal_c;
        };
        const auto column = [&](const L& first_c, const L& second_c, const L& normal_c) {
            return Vectors{entry(f1.x, first_c, f2.x, second_c, n.x, normal_c),
                           entry(f1.y, first_c, f2.y, second_c, n.y, normal_c),
                           entry(f1.z, first_c, f2.z, second_c, n.z, normal_c)};
        };
        Rows(found, begin, count)
            .store(column(first.x, second.x, normal.x), column(first.y, second.y, normal.y),
                   column(first.z, second.z, normal.z));
    }
}

/// What prism_between() takes of four prisms.
struct Prisms
{
    Vectors N, d, d_of[3], c[3];

    Prisms(const double* coarse, const double* fine, const int* triangles, int begin, int count)
    {
        const Corners b(coarse, triangles, begin, count), x(fine, triangles, begin, count);
        const Vectors e1 = b.at[1] - b.at[0], e2 = b.at[2] - b.at[0];
        const Vectors g1 = x.at[1] - x.at[0] + 0.5 * e1, g2 = x.at[2] - x.at[0] + 0.5 * e2;
        N = (1.0 / 18) * (cross(g1, g2) + 0.75 * cross(e1, e2));
        for (int k = 0; k < 3; ++k)
            d_of[k] = x.at[k] - b.at[k];
        d = d_of[0] + d_of[1] + d_of[2];
        c[0] = (1.0 / 18) * (g1 - g2);
        c[1] = (1.0 / 18) * g2;
        c[2] = (-1.0 / 18) * g1;
    }

    /// The moment of a cell.
    Vectors moment(int corner) const
    {
        return sinew::share_of_others * d + sinew::share_of_own * d_of[corner];
    }
};

/// Three numbers of each of four triangles.
struct Triples
{
    double* to;
    int lanes;

    Triples(double* found, int begin, int count)
        : to(found + 3 * static_cast<long long>(begin)), lanes(count - begin < 4 ? count - begin : 4)
    {
    }
    void store(int k, const L& values) const
    {
        for (int lane = 0; lane < lanes; ++lane)
            to[3 * lane + k] = values[lane];
    }
};

void volumes(const double* coarse, const double* fine, const int* triangles, int count, double* found)
{
    for (int begin = 0; begin < count; begin += 4) {
        const Prisms p(coarse, fine, triangles, begin, count);
        const Triples to(found, begin, count);
        for (int k = 0; k < 3; ++k)
            to.store(k, dot(p.N, p.moment(k)));
    }
}

void forces(const double* coarse, const double* fine, const double* multipliers, const int* triangles,
            int count, double* found)
{
    for (int begin = 0; begin < count; begin += 4) {
        const Prisms p(coarse, fine, triangles, begin, count);
        const auto own_of = [&](int corner) {
            const auto of = [&](int lane) {
                const int t = begin + lane < count ? begin + lane : count - 1;
                return sinew::share_of_own * multipliers[triangles[3 * t + corner]];
            };
            return L{of(0), of(1), of(2), of(3)};
        };
        const L own[3] = {own_of(0), own_of(1), own_of(2)};
        const L others = constant(sinew::share_of_others / sinew::share_of_own) * (own[0] + own[1] + own[2]);
        const Vectors P = others * p.d + own[0] * p.d_of[0] + own[1] * p.d_of[1] + own[2] * p.d_of[2];
        Vectors force[3];
        for (int k = 0; k < 3; ++k)
            force[k] = (others + own[k]) * p.N + cross(p.c[k], P);
        Rows(found, begin, count).store(force[0], force[1], force[2]);
    }
}

void changes(const double* coarse, const double* fine, const double* move, const int* triangles, int count,
             double* found)
{
    for (int begin = 0; begin < count; begin += 4) {
        const Prisms p(coarse, fine, triangles, begin, count);
        const Corners m(move, triangles, begin, count);
        const Vectors Q = cross(m.at[0], p.c[0]) + cross(m.at[1], p.c[1]) + cross(m.at[2], p.c[2]);
        const Vectors all = sinew::share_of_others * (m.at[0] + m.at[1] + m.at[2]);
        const Triples to(found, begin, count);
        for (int k = 0; k < 3; ++k)
            to.store(k, dot(p.N, all + sinew::share_of_own * m.at[k]) + dot(p.moment(k), Q));
    }
}

} // namespace

const sinew::DetailKernels sinew::DetailKernels::SINEW_INSTRUCTIONS{::maps, ::volumes, ::forces, ::changes};
