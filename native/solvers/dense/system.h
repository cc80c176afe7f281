// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/simd/aligned.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sinew {

/// A packed copy of the right factor of DenseKernels::add_product.
class PackedColumns
{
public:
    PackedColumns() = default;
    /// \param from  (rows, columns), row-major with `stride`; negated if `sign` is -1.
    PackedColumns(const double* from, int rows, int columns, std::size_t stride, double sign = 1.0);

    int strips() const { return strips_; }
    /// c (rows, strips() * strip_width) += a (rows, inner) * this; see DenseKernels.
    void multiply_add(const double* a, int stride_a, int rows, double* c, int stride_c,
                      const int* place = nullptr) const;

private:
    int rows_ = 0, strips_ = 0;
    AlignedVector<double> packed_;
};

/// Solves A X = B for a general square A, by blocked Gaussian elimination with row pivoting. Results agree to
/// the last bit on any number of threads and with any set of instructions.
class DenseSystem
{
public:
    /// Makes a system of zeros, of (size + columns) * size numbers.
    /// \throw OutOfMemory  it would take more than limit_memory() allows.
    DenseSystem(int size, int columns);

    static std::int64_t bytes(int size, int columns);

    int size() const { return size_; }
    double* row(int i) { return entries_.data() + static_cast<std::size_t>(i) * stride_; } ///< of A
    double* right_side(int i) { return row(i) + size_; }                                   ///< of B

    /// Replaces B by X and destroys A, so call it once. Cost: 2/3 size^3 + 2 size^2 columns operations.
    /// If A is singular, X is huge or not finite, and one of pivot_sizes() is zero or tiny.
    /// \throw Cancelled
    void solve(const Progress& progress);

    const double* solution(int i) const
    {
        return entries_.data() + static_cast<std::size_t>(i) * stride_ + size_;
    }
    /// (size) magnitudes of the pivots, in the order of A's columns.
    const std::vector<double>& pivot_sizes() const { return pivot_sizes_; }
    std::size_t stride() const { return stride_; }

private:
    void eliminate(int begin, int end);
    void substitute(int begin, int end);

    int size_, columns_;
    std::size_t stride_;
    AlignedVector<double> entries_;
    std::vector<double> pivot_sizes_;
};

} // namespace sinew
