// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of PyramidKernels, compiled once for each set of instructions; see lane_types.inl.

#include "native/local_global/arap/arap_kernels.h"

#include "native/local_global/arap/columns.inl"

namespace {

using sinew::PyramidView;

void covariances(const PyramidView& view, int begin, int end, double* S)
{
    for (int i = begin; i < end; ++i) {
        const L own = point(view.points, i);
        L tip = constant(0.0);
        Columns s{tip, tip, tip};
        for (int a = view.offsets[i]; a < view.offsets[i + 1]; ++a) {
            const L y = point(view.points, view.ends[a]) - own;
            tip = tip - view.shares[a] * y;
            s = s + outer(y, point(view.edges, a));
        }
        store(S, i - begin, scaled(view.sides[i], s) + outer(view.stiffness[i] * tip, point(view.tips, i)));
    }
}

double forces(const PyramidView& view, int begin, int end, const double* R, double* forces, double* sums)
{
    L total = constant(0.0);
    for (int i = begin; i < end; ++i) {
        const Columns turn = packed(R, i);
        const L own = point(view.points, i);
        L tip = constant(0.0), all = tip;
        for (int a = view.offsets[i]; a < view.offsets[i + 1]; ++a)
            tip = tip - view.shares[a] * (point(view.points, view.ends[a]) - own);
        const L off = tip - product(turn, point(view.tips, i)), pull = view.stiffness[i] * off;
        total = total + pull * off;
        for (int a = view.offsets[i]; a < view.offsets[i + 1]; ++a) {
            const L gap = point(view.points, view.ends[a]) - own - product(turn, point(view.edges, a));
            const L stretch = view.sides[i] * gap;
            total = total + stretch * gap;
            const L force = stretch - view.shares[a] * pull;
            all = all - force;
            store_three(forces + 3 * static_cast<std::size_t>(a), force);
        }
        store_three(sums + 3 * static_cast<std::size_t>(i), all);
    }
    return sum(total);
}

void gather(const PyramidView& view, int begin, int end, const double* forces, const double* sums,
            double* gradient)
{
    for (int i = begin; i < end; ++i) {
        L at = point(sums, i);
        for (int a = view.offsets[i]; a < view.offsets[i + 1]; ++a)
            if (view.backs[a] >= 0)
                at = at + point(forces, view.backs[a]);
        store_three(gradient + 3 * static_cast<std::size_t>(i), at);
    }
}

} // namespace

const sinew::PyramidKernels sinew::PyramidKernels::SINEW_INSTRUCTIONS{::covariances, ::forces, ::gather};
