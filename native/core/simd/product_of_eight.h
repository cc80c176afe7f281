// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// Eight rows of a matrix times three columns. Every variant does the same operations in the same order and
/// fuses none, so results agree to the last bit.
struct ProductOfEight
{
    /// sums (8, 3) = start (8, 3) + matrix (8, columns) * factors (columns, 3). `block` holds `start` and
    /// then `matrix`. Both and `sums` are column-major, `factors` is row-major.
    void (*multiply)(const double* block, int columns, const double* factors, double* sums);

    static const ProductOfEight baseline, avx2;
};

} // namespace sinew
