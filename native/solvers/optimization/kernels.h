// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// Inner products of a new correction pair (s, y, L^-1 y) and of the new gradient g.
struct PairProducts
{
    double ss, yy, sy, y_Ly, s_g, Ly_g, z_g;
};

/// The loops of minimize() over `count` numbers. Every variant does the same operations in the same order and
/// fuses none, so results agree to the last bit.
struct LbfgsKernels
{
    /// With d = z + sum_k share_s[k] s[k] - share_Ly[k] Ly[k] over some pairs: trial = x - t d, and
    /// step = -t d unless it is null.
    void (*step)(const double* x, const double* z, int pairs, const float* const* s, const float* const* Ly,
                 const double* share_s, const double* share_Ly, double t, int count, double* trial,
                 float* step);
    /// With y = g - old_g: Ly = z - old_z, and the products of s, y, Ly, g and z.
    PairProducts (*pair)(const double* old_g, const double* g, const double* old_z, const double* z,
                         const float* s, int count, float* Ly);
    /// The products of g with some pairs: products[2 k] is that with s[k], products[2 k + 1] that with Ly[k].
    void (*products)(const double* g, int pairs, const float* const* s, const float* const* Ly, int count,
                     double* products);

    static const LbfgsKernels baseline, avx2;
};

} // namespace sinew
