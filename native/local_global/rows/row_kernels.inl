// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of RowKernels, compiled once for each set of instructions; see lane_types.inl.

#include "native/local_global/arap/columns.inl"

namespace {

using sinew::RowView;

/// A sum of terms of row k.
inline L combined(const RowView& view, int k)
{
    int a = view.terms[k];
    const int end = view.terms[k + 1];
    L sum = constant(0.0);
    for (; a < end; ++a)
        sum = sum + view.coefficients[a] * point(view.points, view.term_points[a]);
    return sum;
}

inline L cross(L a, L b) { return turned(a * turned(b) - turned(a) * b); }

inline Columns nothing() { return {constant(0.0), constant(0.0), constant(0.0)}; }

void stretches(const RowView& view, int begin, int end, double* r, double* S)
{
    for (int g = begin; g < end; ++g) {
        Columns s = nothing();
        for (int k = view.rows[g]; k < view.rows[g + 1]; ++k) {
            const L y = combined(view, k);
            store_three(r + 3 * static_cast<std::size_t>(k), y);
            s = s + outer(y, view.weights[k] * point(view.vectors, k));
        }
        store(S, g - begin, s);
    }
}

double forces(const RowView& view, int begin, int end, const double* R, double* r)
{
    L total = constant(0.0);
    for (int g = begin; g < end; ++g) {
        const Columns turn = packed(R, g);
        for (int k = view.rows[g]; k < view.rows[g + 1]; ++k) {
            const L gap = point(r, k) - product(turn, point(view.vectors, k));
            const L force = view.weights[k] * gap;
            total = total + force * gap;
            store_three(r + 3 * static_cast<std::size_t>(k), force);
        }
    }
    return sum(total);
}

void residuals(const RowView& view, int begin, int end, const double* R, double* r)
{
    for (int k = begin; k < end; ++k) {
        L gap = combined(view, k);
        for (int side = 0; side < 2; ++side)
            if (const int g = view.row_groups[2 * k + side]; g >= 0)
                gap = gap - product(packed(R, g), point(view.vectors, 2 * k + side));
        store_three(r + 3 * static_cast<std::size_t>(k), gap);
    }
}

void torques(const RowView& view, int begin, int end, const double* R, const double* r, double* t)
{
    for (int g = begin; g < end; ++g) {
        const Columns turn = packed(R, g);
        L sum = constant(0.0);
        for (int a = view.first_turns[g]; a < view.first_turns[g + 1]; ++a) {
            const int k = view.turns[a] / 2;
            sum =
                sum + view.weights[k] * cross(product(turn, point(view.vectors, view.turns[a])), point(r, k));
        }
        store_three(t + 3 * static_cast<std::size_t>(g - begin), sum);
    }
}

void covariances(const RowView& view, int begin, int end, const double* R, const double* r, double* S)
{
    for (int g = begin; g < end; ++g) {
        const Columns turn = packed(R, g);
        Columns s = nothing();
        for (int a = view.first_turns[g]; a < view.first_turns[g + 1]; ++a) {
            const int k = view.turns[a] / 2;
            const L u = point(view.vectors, view.turns[a]);
            s = s + outer(point(r, k) + product(turn, u), view.weights[k] * u);
        }
        store(S, g - begin, s);
    }
}

double weigh(const RowView& view, int begin, int end, double* r)
{
    L total = constant(0.0);
    for (int k = begin; k < end; ++k) {
        const L gap = point(r, k), force = view.weights[k] * gap;
        total = total + force * gap;
        store_three(r + 3 * static_cast<std::size_t>(k), force);
    }
    return sum(total);
}

/// The three edges of a cell of four points that leave the first of them.
struct Edges
{
    L a, b, c;
    Edges(const double* points, const int* corners)
    {
        const L first = point(points, corners[0]);
        a = point(points, corners[1]) - first;
        b = point(points, corners[2]) - first;
        c = point(points, corners[3]) - first;
    }
    Edges(L x, L y, L z) : a(x), b(y), c(z) {}
};

inline Edges times(const double* m, const Edges& y)
{
    return {m[0] * y.a + m[1] * y.b + m[2] * y.c, m[1] * y.a + m[3] * y.b + m[4] * y.c,
            m[2] * y.a + m[4] * y.b + m[5] * y.c};
}

void cell_covariances(const RowView& view, int begin, int end, double* S)
{
    for (int g = begin; g < end; ++g) {
        const int* const corners = view.corners + 4 * static_cast<std::size_t>(g);
        const Edges z(view.base, corners);
        const Edges m = times(view.matrices + 6 * static_cast<std::size_t>(g), Edges(view.points, corners));
        store(S, g - begin, outer(m.a, z.a) + outer(m.b, z.b) + outer(m.c, z.c));
    }
}

double cell_forces(const RowView& view, int begin, int end, const double* R, double* f)
{
    L total = constant(0.0);
    for (int g = begin; g < end; ++g) {
        const int* const corners = view.corners + 4 * static_cast<std::size_t>(g);
        const Columns turn = packed(R, g);
        const Edges y(view.points, corners), z(view.base, corners);
        const Edges gap{y.a - product(turn, z.a), y.b - product(turn, z.b), y.c - product(turn, z.c)};
        const Edges force = times(view.matrices + 6 * static_cast<std::size_t>(g), gap);
        total = total + force.a * gap.a + force.b * gap.b + force.c * gap.c;
        double* const to = f + 12 * static_cast<std::size_t>(g);
        store_three(to, constant(0.0) - (force.a + force.b + force.c));
        store_three(to + 3, force.a);
        store_three(to + 6, force.b);
        store_three(to + 9, force.c);
    }
    return sum(total);
}

void gather(const RowView& view, int begin, int end, const double* forces, double* gradient)
{
    for (int i = begin; i < end; ++i) {
        L sum = constant(0.0);
        for (int a = view.parts[i]; a < view.parts[i + 1]; ++a)
            sum = sum + view.part_shares[a] * point(forces, view.part_forces[a]);
        store_three(gradient + 3 * static_cast<std::size_t>(i), sum);
    }
}

} // namespace

const sinew::RowKernels sinew::RowKernels::SINEW_INSTRUCTIONS{::stretches,        ::forces,      ::residuals,
                                                              ::torques,          ::covariances, ::weigh,
                                                              ::cell_covariances, ::cell_forces, ::gather};
