// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// A bilinear quad, P(s, t) = centre + s along + t across + s t twist for s and t in [-1, 1]. Its normal
/// dP/ds x dP/dt is normal[0] + s normal[1] + t normal[2]: the product of s and t cancels.
struct QuadPatch
{
    double centre[3], along[3], across[3], twist[3];
    double normal[3][3];
};

/// A patch as seen from a point x near it. All is relative to a place (s0, t0) of the patch near x: with
/// s = s0 + a and t = t0 + b, P - x = a along + b across + a b twist - offset.
struct NearPatch
{
    double along[3], across[3], twist[3], offset[3];
    double low, high;        ///< the range of a
    double height[2];        ///< (P - x) . normal is height[0] + b height[1] + a (lean[0] + b lean[1])
    double lean[2];
};

/// Integrals over bilinear quads. Every variant does the same operations in the same order, fuses none and
/// calls no library, so results agree to the last bit.
struct QuadKernels
{
    int lanes;
    /// The integrals of (P - x) . normal / r^3 times 1, s, t, s t, and of 1 / r times 1, s, t over s and t,
    /// by Gauss's rule with n x m nodes, for one point x per lane that is not near.
    /// \param points        (3, lanes)
    /// \param rule, other   (n, 2) and (m, 2) nodes and weights for s and for t
    /// \param[out] moments  (7, lanes)
    void (*moments)(const QuadPatch& patch, const double* points, const double* rule, int n,
                    const double* other, int m, double* moments);
    /// The integrals over a, in closed form, of the same for one point near the patch and each b: of
    /// (P - x) . normal / r^3 times 1 and a, and of 1 / r times 1 and a.
    /// \param b              (count), a multiple of most_quad_lanes
    /// \param[out] integrals (4, count)
    void (*lines)(const NearPatch& patch, const double* b, int count, double* integrals);

    static const QuadKernels baseline, avx2, avx512;
};

constexpr int most_quad_lanes = 8;

} // namespace sinew
