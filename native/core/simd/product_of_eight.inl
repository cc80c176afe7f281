// SPDX-License-Identifier: GPL-3.0-or-later
// The body of ProductOfEight, compiled once for each set of instructions.

#include "native/core/simd/lane_types.inl"

namespace {

/// Two vectors hold the eight rows, so the three columns are six sums that grow side by side.
void multiply(const double* block, int columns, const double* factors, double* sums)
{
    Lanes<double> sum[6], b[2];
    for (int k = 0; k < 6; ++k)
        sum[k] = load(block + 4 * k);
    block += 24;
    for (int c = 0; c < columns; ++c, block += 8, factors += 3) {
        b[0] = load(block);
        b[1] = load(block + 4);
        for (int k = 0; k < 6; ++k)
            sum[k] = sum[k] + factors[k / 2] * b[k % 2];
    }
    for (int k = 0; k < 6; ++k)
        store(sums + 4 * k, sum[k]);
}

} // namespace

const sinew::ProductOfEight sinew::ProductOfEight::SINEW_INSTRUCTIONS{::multiply};
