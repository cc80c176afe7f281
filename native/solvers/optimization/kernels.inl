// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of LbfgsKernels, compiled once for each set of instructions; see lane_types.inl.

#include "native/core/simd/lane_types.inl"

namespace {

using sinew::PairProducts;
using D = Lanes<double>;
using F = Lanes<float>;

inline double sum(D a) { return (a[0] + a[1]) + (a[2] + a[3]); }

void step(const double* x, const double* z, int pairs, const float* const* s, const float* const* Ly,
          const double* share_s, const double* share_Ly, double t, int count, double* trial, float* step)
{
    constexpr int block = 16;
    int at = 0;
    for (; at + block <= count; at += block) {
        D d[block / 4];
        for (int j = 0; j < block / 4; ++j)
            d[j] = load(z + at + 4 * j);
        for (int k = 0; k < pairs; ++k) {
            const float *s_k = s[k] + at, *Ly_k = Ly[k] + at;
            for (int j = 0; j < block / 4; ++j)
                d[j] = d[j] +
                       (share_s[k] * widened(load(s_k + 4 * j)) - share_Ly[k] * widened(load(Ly_k + 4 * j)));
        }
        for (int j = 0; j < block / 4; ++j) {
            d[j] = t * d[j];
            store(trial + at + 4 * j, load(x + at + 4 * j) - d[j]);
            if (step)
                store(step + at + 4 * j, narrowed(constant(0.0) - d[j]));
        }
    }
    for (; at < count; ++at) {
        double d = z[at];
        for (int k = 0; k < pairs; ++k)
            d += share_s[k] * s[k][at] - share_Ly[k] * Ly[k][at];
        d *= t;
        trial[at] = x[at] - d;
        if (step)
            step[at] = static_cast<float>(0.0 - d);
    }
}

PairProducts pair(const double* old_g, const double* g, const double* old_z, const double* z, const float* s,
                  int count, float* Ly)
{
    D ss = constant(0.0), yy = ss, sy = ss, y_Ly = ss, s_g = ss, Ly_g = ss, z_g = ss;
    int k = 0;
    for (; k + 4 <= count; k += 4) {
        const D g_k = load(g + k), y = g_k - load(old_g + k), z_k = load(z + k), s_k = widened(load(s + k));
        const F single = narrowed(z_k - load(old_z + k));
        store(Ly + k, single);
        const D Ly_k = widened(single);
        ss = ss + s_k * s_k;
        yy = yy + y * y;
        sy = sy + s_k * y;
        y_Ly = y_Ly + y * Ly_k;
        s_g = s_g + s_k * g_k;
        Ly_g = Ly_g + Ly_k * g_k;
        z_g = z_g + z_k * g_k;
    }
    PairProducts sums{sum(ss), sum(yy), sum(sy), sum(y_Ly), sum(s_g), sum(Ly_g), sum(z_g)};
    for (; k < count; ++k) {
        const double y = g[k] - old_g[k];
        Ly[k] = static_cast<float>(z[k] - old_z[k]);
        sums.ss += static_cast<double>(s[k]) * s[k];
        sums.yy += y * y;
        sums.sy += s[k] * y;
        sums.y_Ly += y * Ly[k];
        sums.s_g += s[k] * g[k];
        sums.Ly_g += Ly[k] * g[k];
        sums.z_g += z[k] * g[k];
    }
    return sums;
}

void products(const double* g, int pairs, const float* const* s, const float* const* Ly, int count,
              double* products)
{
    constexpr int width = 4;
    for (int pair = 0; pair < pairs; ++pair) {
        D with_s[width], with_Ly[width];
        for (int j = 0; j < width; ++j)
            with_s[j] = with_Ly[j] = constant(0.0);
        int k = 0;
        for (; k + 4 * width <= count; k += 4 * width)
            for (int j = 0; j < width; ++j) {
                const D g_k = load(g + k + 4 * j);
                with_s[j] = with_s[j] + widened(load(s[pair] + k + 4 * j)) * g_k;
                with_Ly[j] = with_Ly[j] + widened(load(Ly[pair] + k + 4 * j)) * g_k;
            }
        double s_g = sum((with_s[0] + with_s[1]) + (with_s[2] + with_s[3]));
        double Ly_g = sum((with_Ly[0] + with_Ly[1]) + (with_Ly[2] + with_Ly[3]));
        for (; k < count; ++k) {
            s_g += s[pair][k] * g[k];
            Ly_g += Ly[pair][k] * g[k];
        }
        products[2 * pair] = s_g;
        products[2 * pair + 1] = Ly_g;
    }
}

} // namespace

const sinew::LbfgsKernels sinew::LbfgsKernels::SINEW_INSTRUCTIONS{::step, ::pair, ::products};
