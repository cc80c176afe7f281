// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of PropagationKernels, compiled once for each set of instructions. One lane is one point.

#include "native/core/simd/lane_math.inl"

#include <algorithm>
#include <bit>
#include <cstddef>

namespace {

using sinew::PropagatedMotion;
using sinew::PropagatedPart;
using L = Lanes<double>;

struct Three
{
    L x, y, z;
};

inline Three operator+(const Three& a, const Three& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Three operator-(const Three& a, const Three& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Three operator*(const Three& a, L factor) { return {a.x * factor, a.y * factor, a.z * factor}; }
inline Three cross(const Three& a, const Three& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Three spread(const double* three)
{
    return {constant(three[0]), constant(three[1]), constant(three[2])};
}

/// (-1)^k / (2 k + more)!
template <int more>
struct Coefficients
{
    double of[12];

    constexpr Coefficients() : of{}
    {
        double factor = 1.0;
        for (int k = 0; k < 12; ++k) {
            of[k] = factor;
            factor /= -(2 * k + 1 + more) * (2 * k + 2 + more);
        }
    }
};

/// The sum of coefficients u^k: cos, or sin(a) / a with `more` 1, from u = a^2 up to a right angle. Even and
/// odd powers are two sums, so that the processor does not wait for one.
template <int more>
inline L series(L u)
{
    constexpr Coefficients<more> c;
    const L square = u * u;
    L even = constant(c.of[10]), odd = constant(c.of[11]);
    for (int k = 8; k >= 0; k -= 2) {
        even = even * square + constant(c.of[k]);
        odd = odd * square + constant(c.of[k + 1]);
    }
    return even + u * odd;
}

/// Moves as many points as a vector has lanes.
/// \return a bit for each lane that is left to the caller.
int move_lanes(const PropagatedPart& part, const double* t, int stride, const double* from, double* to)
{
    const L zero = constant(0.0);
    L n[9];
    for (int k = 0; k < 9; ++k)
        n[k] = constant(part.identity[k]);
    Three centre{zero, zero, zero}, shift{zero, zero, zero};
    L turning = zero;
    for (int m = 0; m < part.count; ++m) {
        const PropagatedMotion& motion = part.motions[m];
        const L share = load(t + static_cast<std::ptrdiff_t>(m) * stride);
        for (int k = 0; k < 9; ++k)
            n[k] = n[k] + share * constant(motion.numbers[k]);
        const L weight = larger(share, zero) * constant(motion.turning);
        centre = centre + spread(motion.centre) * weight;
        turning = turning + weight;
        shift = shift + spread(motion.move) * share;
    }
    const L quarter = constant(0.25) * (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const L sine = series<1>(quarter), whole = sine * series<0>(quarter), half = constant(0.5) * sine * sine;

    Three y;
    load_points(from, y.x, y.y, y.z);
    const auto turns = above(turning, zero);
    const L inverse = constant(1.0) / choose(turns, turning, constant(1.0));
    const Three away = y - centre * inverse;
    const Three arm{choose(turns, away.x, zero), choose(turns, away.y, zero), choose(turns, away.z, zero)};
    const Three stretched{n[3] * arm.x + n[4] * arm.y + n[5] * arm.z,
                          n[4] * arm.x + n[6] * arm.y + n[7] * arm.z,
                          n[5] * arm.x + n[7] * arm.y + n[8] * arm.z};
    const Three turn{n[0], n[1], n[2]}, across = cross(turn, stretched);
    const Three v = stretched + across * whole + cross(turn, across) * half;
    const double* const R = part.mean;
    const auto row = [&](int r) {
        return constant(R[3 * r]) * v.x + constant(R[3 * r + 1]) * v.y + constant(R[3 * r + 2]) * v.z;
    };
    const Three found = y + (Three{row(0), row(1), row(2)} - arm) + shift;
    store_points(to, found.x, found.y, found.z);
    // Blends that are not numbers are left, too.
    return mask_bits(above(constant(2.5), quarter)) ^ ((1 << lane_count) - 1);
}

int move(const PropagatedPart& part, int n, const double* t, int stride, const double* from, double* to)
{
    for (int i = 0; i < n; i += lane_count)
        if (const int left = move_lanes(part, t + i, stride, from + 3 * i, to + 3 * i))
            return std::min(n, i + std::countr_zero(static_cast<unsigned>(left)));
    return n;
}

} // namespace

const sinew::PropagationKernels sinew::PropagationKernels::SINEW_INSTRUCTIONS{::move};
