// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of BodyKernels, compiled once for each set of instructions; see lane_types.inl.

#include "native/local_global/arap/columns.inl"

namespace {

using sinew::BodyView;

/// m B, where `form` has the entries B_11, B_12, B_13, B_22, B_23, B_33.
inline Columns times(const Columns& m, const double* form)
{
    return {form[0] * m.x + form[1] * m.y + form[2] * m.z, form[1] * m.x + form[3] * m.y + form[4] * m.z,
            form[2] * m.x + form[4] * m.y + form[5] * m.z};
}

inline const double* joint(const BodyView& view, int a)
{
    return view.joints + sinew::joint_numbers * static_cast<std::size_t>(a);
}

void covariances(const BodyView& view, int begin, int end, const double* R, double* S)
{
    const Columns zero{constant(0.0), constant(0.0), constant(0.0)};
    for (int i = 0; i < end - begin; ++i)
        store(S, i, zero);
    for (int i = begin; i < end; ++i) {
        fetch<3>(view.points, i);
        fetch<9>(R, i);
        Columns s = columns(S, i - begin);
        const Columns r = packed(R, i);
        const L t = point(view.points, i);
        const int* const first = view.first + 2 * static_cast<std::size_t>(i);
        int a = first[0];
        for (; a < first[1]; ++a) {
            const double* const d = joint(view, a);
            const int j = view.others[a];
            const Columns other = packed(R, j);
            const L p = load(d), q = load(d + 3), t_j = point(view.points, j);
            s = s + outer(d[12] * (t_j + product(other, q) - t), p) + times(other, d + 6);
            store(S, j - begin,
                  columns(S, j - begin) + outer(d[12] * (t + product(r, p) - t_j), q) + times(r, d + 6));
        }
        for (; a < first[2]; ++a) {
            const double* const d = joint(view, a);
            const int j = view.others[a];
            const Columns other = packed(R, j);
            s = s + outer(d[12] * (point(view.points, j) + product(other, load(d + 3)) - t), load(d)) +
                times(other, d + 6);
        }
        store(S, i - begin, s);
    }
}

void torques(const double* S, const double* R, int count, double* t)
{
    for (int i = 0; i < count; ++i) {
        const Columns r = packed(R, i), s = columns(S, i);
        store_three(t + 3 * static_cast<std::size_t>(i),
                    turned((r.x * turned(s.x) - turned(r.x) * s.x) + (r.y * turned(s.y) - turned(r.y) * s.y) +
                           (r.z * turned(s.z) - turned(r.z) * s.z)));
    }
}

double energy(const BodyView& view, int begin, int end, const double* R, double* gradient)
{
    double forces[4 * sinew::graph_chunk];
    for (int i = 0; i < end - begin; ++i)
        store(forces + 4 * i, constant(0.0));
    L total = constant(0.0);
    for (int i = begin; i < end; ++i) {
        fetch<3>(view.points, i);
        fetch<9>(R, i);
        const Columns r = packed(R, i);
        const L t = point(view.points, i);
        double* const force_at = forces + 4 * (i - begin);
        L force = load(force_at);
        const int* const first = view.first + 2 * static_cast<std::size_t>(i);
        const auto add = [&](int a, double share) {
            const double* const d = joint(view, a);
            const int j = view.others[a];
            const Columns other = packed(R, j);
            const L gap = (t + product(r, load(d))) - (point(view.points, j) + product(other, load(d + 3)));
            const L pull = d[12] * gap;
            const Columns turn{r.x - other.x, r.y - other.y, r.z - other.z};
            const Columns bent = times(turn, d + 6);
            total = total + share * (pull * gap + bent.x * turn.x + bent.y * turn.y + bent.z * turn.z);
            force = force + pull;
            return pull;
        };
        int a = first[0];
        for (; a < first[1]; ++a) {
            const L pull = add(a, 1.0);
            double* const to = forces + 4 * (view.others[a] - begin);
            store(to, load(to) - pull);
        }
        for (; a < first[2]; ++a)
            add(a, view.others[a] < view.free ? 0.5 : 1.0);
        store(force_at, force);
    }
    for (int i = 0; i < end - begin; ++i)
        store_three(gradient + 3 * static_cast<std::size_t>(i), load(forces + 4 * i));
    return sum(total);
}

} // namespace

const sinew::BodyKernels sinew::BodyKernels::SINEW_INSTRUCTIONS{::covariances, ::torques, ::energy};
