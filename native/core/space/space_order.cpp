// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/space/space_order.h"

#include "native/core/parallel.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace sinew {

namespace {

constexpr int bits = 21; ///< per axis

/// Puts two zeros between the bits of a number of 21 bits.
std::uint64_t spread(std::uint64_t x)
{
    x = (x | x << 32) & 0x1f00000000ffffULL;
    x = (x | x << 16) & 0x1f0000ff0000ffULL;
    x = (x | x << 8) & 0x100f00f00f00f00fULL;
    x = (x | x << 4) & 0x10c30c30c30c30c3ULL;
    return (x | x << 2) & 0x1249249249249249ULL;
}

} // namespace

std::vector<std::uint64_t> morton_codes(PointsView points)
{
    std::vector<std::uint64_t> codes(static_cast<std::size_t>(points.rows()), 0);
    if (codes.empty())
        return codes;
    const Eigen::RowVector3d low = points.colwise().minCoeff();
    const double extent = std::max((points.colwise().maxCoeff() - low).maxCoeff(), 1e-300);
    parallel_for(static_cast<int>(codes.size()), [&](int i) {
        for (int axis = 0; axis < 3; ++axis) {
            const double place = (points(i, axis) - low[axis]) / extent * ((1 << bits) - 1);
            codes[i] |= spread(static_cast<std::uint64_t>(std::max(0.0, place))) << axis;
        }
    });
    return codes;
}

std::vector<int> space_order(PointsView points)
{
    constexpr int digit = 10; // bits that one pass sorts by, from the lowest to the highest
    const std::vector<std::uint64_t> codes = morton_codes(points);
    std::vector<int> order(codes.size()), next(codes.size());
    std::iota(order.begin(), order.end(), 0);
    for (int shift = 3 * (bits - digit); shift < 3 * bits; shift += digit) {
        std::array<int, (1 << digit) + 1> begins{};
        const auto digit_of = [&](int i) { return codes[i] >> shift & ((1 << digit) - 1); };
        for (const int i : order)
            ++begins[digit_of(i) + 1];
        std::partial_sum(begins.begin(), begins.end(), begins.begin());
        for (const int i : order)
            next[begins[digit_of(i)]++] = i;
        order.swap(next);
    }
    return order;
}

} // namespace sinew
