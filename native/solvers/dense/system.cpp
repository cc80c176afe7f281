// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/dense/system.h"

#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/solvers/dense/kernels.h"

#include <algorithm>
#include <cmath>

namespace sinew {

namespace {

constexpr int panel = 64;       ///< columns that are eliminated at once
constexpr int tile = 48; ///< rows that a thread updates at once; their part of a panel stays in its cache
constexpr int row_padding = 16; ///< numbers; without them, rows of 2^k numbers would compete for cache lines

int padded(int count) { return (count + strip_width - 1) / strip_width * strip_width; }

/// row -= factor * other
void subtract(double* row, double factor, const double* other, int count)
{
    for (int j = 0; j < count; ++j)
        row[j] -= factor * other[j];
}

} // namespace

PackedColumns::PackedColumns(const double* from, int rows, int columns, std::size_t stride, double sign)
    : rows_(rows), strips_(padded(columns) / strip_width),
      packed_(static_cast<std::size_t>(rows) * static_cast<std::size_t>(padded(columns)))
{
    parallel_for(
        strips_,
        [&](int s) {
            double* to = packed_.data() + static_cast<std::size_t>(s) * strip_width * rows;
            const int width = std::min(strip_width, columns - s * strip_width);
            for (int r = 0; r < rows; ++r, to += strip_width)
                for (int j = 0; j < width; ++j)
                    to[j] = sign * from[static_cast<std::size_t>(r) * stride + s * strip_width + j];
        },
        16);
}

void PackedColumns::multiply_add(const double* a, int stride_a, int rows, double* c, int stride_c,
                                 const int* place) const
{
    widest_kernels<DenseKernels>().add_product(a, stride_a, 1, rows, rows_, packed_.data(), strips_, c,
                                               stride_c, place);
}

std::int64_t DenseSystem::bytes(int size, int columns)
{
    return static_cast<std::int64_t>(size) * (padded(size + columns) + row_padding) * 8;
}

DenseSystem::DenseSystem(int size, int columns)
    : size_(size), columns_(columns), stride_(static_cast<std::size_t>(padded(size + columns) + row_padding))
{
    require_memory(bytes(size, columns), "the dense system");
    entries_.resize(stride_ * static_cast<std::size_t>(size));
    pivot_sizes_.resize(static_cast<std::size_t>(size));
}

/// Eliminates columns [begin, end) in the rows from `begin` on.
void DenseSystem::eliminate(int begin, int end)
{
    for (int k = begin; k < end; ++k) {
        int best = k;
        for (int i = k + 1; i < size_; ++i)
            if (std::abs(row(i)[k]) > std::abs(row(best)[k]))
                best = i;
        if (best != k)
            std::swap_ranges(row(k), row(k) + stride_, row(best));
        const double* pivot = row(k);
        pivot_sizes_[static_cast<std::size_t>(k)] = std::abs(pivot[k]);
        for (int i = k + 1; i < size_; ++i) {
            double* line = row(i);
            line[k] /= pivot[k];
            subtract(line + k + 1, line[k], pivot + k + 1, end - k - 1);
        }
    }
}

/// Completes the other columns of rows [begin, end), and subtracts these rows from those below them.
void DenseSystem::substitute(int begin, int end)
{
    const int width = size_ + columns_ - end;
    parallel_chunks(width, 256, [&](int from, int to) {
        for (int k = begin; k < end; ++k)
            for (int j = begin; j < k; ++j)
                subtract(row(k) + end + from, row(k)[j], row(j) + end + from, to - from);
    });
    const PackedColumns done(row(begin) + end, end - begin, width, stride_, -1.0);
    parallel_chunks(size_ - end, tile, [&](int from, int to) {
        done.multiply_add(row(end + from) + begin, static_cast<int>(stride_), to - from,
                          row(end + from) + end, static_cast<int>(stride_));
    });
}

void DenseSystem::solve(const Progress& progress)
{
    for (int begin = 0; begin < size_; begin += panel) {
        const double left = 1.0 - static_cast<double>(begin) / size_;
        progress.tick(1.0 - left * left * left, "solving for the flux");
        const int end = std::min(begin + panel, size_);
        eliminate(begin, end);
        substitute(begin, end);
    }
    for (int begin = (size_ - 1) / panel * panel; begin >= 0; begin -= panel) {
        const int end = std::min(begin + panel, size_);
        for (int k = end - 1; k >= begin; --k) {
            for (int j = k + 1; j < end; ++j)
                subtract(right_side(k), row(k)[j], right_side(j), columns_);
            for (int c = 0; c < columns_; ++c)
                right_side(k)[c] /= row(k)[k];
        }
        const PackedColumns known(right_side(begin), end - begin, columns_, stride_, -1.0);
        parallel_chunks(begin, tile, [&](int from, int to) {
            known.multiply_add(row(from) + begin, static_cast<int>(stride_), to - from, right_side(from),
                               static_cast<int>(stride_));
        });
    }
    progress.tick(1.0, "solving for the flux");
}

} // namespace sinew
