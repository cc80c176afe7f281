// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of QuadKernels for lane_count points or lines at a time, compiled once for each set of
// instructions.

#include "native/core/simd/lane_math.inl"

namespace {

using sinew::NearPatch;
using sinew::QuadPatch;
using L = Lanes<double>;

inline double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

void moments(const QuadPatch& patch, const double* points, const double* rule, int n, const double* other,
             int m, double* moments)
{
    L from[3]; // the centre, seen from the points
    for (int k = 0; k < 3; ++k)
        from[k] = constant(patch.centre[k]) - load(points + k * lane_count);
    const L zero = constant(0.0);
    L sums[7] = {zero, zero, zero, zero, zero, zero, zero};
    for (int j = 0; j < m; ++j) {
        const double t = other[2 * j], weight = other[2 * j + 1];
        double side[3], first[3];
        L r[3];
        for (int k = 0; k < 3; ++k) {
            side[k] = patch.along[k] + t * patch.twist[k];
            first[k] = patch.normal[0][k] + t * patch.normal[2][k];
            r[k] = from[k] + constant(t * patch.across[k]);
        }
        // The line's direction is orthogonal to the normal, so only its middle counts.
        const L flux = constant(first[0]) * r[0] + constant(first[1]) * r[1] + constant(first[2]) * r[2];
        const L lean = constant(patch.normal[1][0]) * r[0] + constant(patch.normal[1][1]) * r[1] +
                       constant(patch.normal[1][2]) * r[2];
        L m0 = zero, m1 = zero, q0 = zero, q1 = zero;
        for (int i = 0; i < n; ++i) {
            const double s = rule[2 * i];
            const L x = r[0] + constant(s * side[0]), y = r[1] + constant(s * side[1]),
                    z = r[2] + constant(s * side[2]);
            const L square = x * x + y * y + z * z;
            const L inverse = constant(rule[2 * i + 1]) / (square * root(square)); // weight / r^3
            const L layer = (flux + constant(s) * lean) * inverse, pole = square * inverse;
            m0 = m0 + layer;
            m1 = m1 + constant(s) * layer;
            q0 = q0 + pole;
            q1 = q1 + constant(s) * pole;
        }
        const L w = constant(weight), wt = constant(weight * t);
        sums[0] = sums[0] + w * m0;
        sums[1] = sums[1] + w * m1;
        sums[2] = sums[2] + wt * m0;
        sums[3] = sums[3] + wt * m1;
        sums[4] = sums[4] + w * q0;
        sums[5] = sums[5] + w * q1;
        sums[6] = sums[6] + wt * q0;
    }
    for (int k = 0; k < 7; ++k)
        store(moments + k * lane_count, sums[k]);
}

void lines(const NearPatch& patch, const double* places, int count, double* integrals)
{
    const L zero = constant(0.0), one = constant(1.0), two = constant(2.0);
    const L low = constant(patch.low), high = constant(patch.high);
    for (int i = 0; i < count; i += lane_count) {
        const L b = load(places + i);
        // The line is D + a V.
        L D[3], V[3];
        for (int k = 0; k < 3; ++k) {
            D[k] = constant(patch.across[k]) * b - constant(patch.offset[k]);
            V[k] = constant(patch.along[k]) + constant(patch.twist[k]) * b;
        }
        const L cx = D[1] * V[2] - D[2] * V[1], cy = D[2] * V[0] - D[0] * V[2],
                cz = D[0] * V[1] - D[1] * V[0];
        const L square = V[0] * V[0] + V[1] * V[1] + V[2] * V[2] + constant(1e-60);
        const L inverse = one / root(square), inverse2 = inverse * inverse;
        const L away = larger((cx * cx + cy * cy + cz * cz) * inverse2, constant(1e-60)); // from the line
        // y is the place on the line, from the foot of the point; `foot` is that of a = 0.
        const L foot = (D[0] * V[0] + D[1] * V[1] + D[2] * V[2]) * inverse, length = square * inverse;
        const L y0 = foot + length * low, y1 = foot + length * high;
        const L r0 = root(away + y0 * y0), r1 = root(away + y1 * y1), product = r0 * r1, sum = r0 + r1;
        // The integral of 1 / r is log((r0 + r1 + l)^2 / 2 (away + y0 y1 + r0 r1)), whose last two terms
        // cancel where the foot lies between the ends.
        const L y01 = y0 * y1, apart = product - y01, whole = sum + (y1 - y0);
        const auto between = above(zero, y01);
        const L top = whole * whole * choose(between, apart, one);
        const L bottom =
            two * choose(between, away * (apart + y0 * y0 + y1 * y1 + away), away + y01 + product);
        const L J = log_of_ratio(top, bottom);
        const L rise = (y1 - y0) * (y1 + y0);
        // Integrals of 1, y and y^2 over r^3.
        const L cosines = y1 / r1 - y0 / r0;
        const L U0 =
            choose(between, cosines / away, rise / choose(between, one, product * (y1 * r0 + y0 * r1)));
        const L U1 = rise / (product * sum), U2 = J - away * U0;
        const L T0 = U0 * inverse, T1 = (U1 - foot * U0) * inverse2,
                T2 = (U2 - foot * (two * U1 - foot * U0)) * inverse2 * inverse;
        const L height = constant(patch.height[0]) + constant(patch.height[1]) * b;
        const L lean = constant(patch.lean[0]) + constant(patch.lean[1]) * b;
        store(integrals + i, height * T0 + lean * T1);
        store(integrals + count + i, height * T1 + lean * T2);
        store(integrals + 2 * count + i, J * inverse);
        store(integrals + 3 * count + i, (rise / sum - foot * J) * inverse2);
    }
}

} // namespace

const sinew::QuadKernels sinew::QuadKernels::SINEW_INSTRUCTIONS{lane_count, ::moments, ::lines};
