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
    /// \param from  (rows, columns), row-major with `stride`; negated where `sign` is -1.
    PackedColumns(const double* from, int rows, int columns, std::size_t stride, double sign = 1.0);

    int strips() const { return strips_; }
    /// c (rows, strips() * strip_width) += a (rows, inner) * this; see DenseKernels.
    void multiply_add(const double* a, int stride_a, int rows, double* c, int stride_c,
                      const int* place = nullptr) const;

private:
    int rows_ = 0, strips_ = 0;
    AlignedVector<double> packed_;
};

/// A X = B for a general square A, by blocked Gaussian elimination with row pivoting. Same bits on any number
/// of threads and with any instruction set.
class DenseSystem
{
public:
    /// All zero; (size + columns) * size numbers.
    /// \throw OutOfMemory  more than limit_memory() allows.
    DenseSystem(int size, int columns);

    static std::int64_t bytes(int size, int columns);

    int size() const { return size_; }
    double* row(int i) { return entries_.data() + static_cast<std::size_t>(i) * stride_; } ///< of A
    double* right_side(int i) { return row(i) + size_; }                                   ///< of B

    /// X in place of B, once; destroys A. Cost 2/3 size^3 + 2 size^2 columns operations.
    /// Where A is singular X is not finite or huge, and a pivot is zero or tiny: ask pivot_sizes().
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
