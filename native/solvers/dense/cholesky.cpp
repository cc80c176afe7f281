// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/dense/cholesky.h"

#include "native/core/memory.h"
#include "native/core/pages.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/solvers/dense/kernels.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sinew {

namespace {

constexpr int panel = 64;       ///< rows that are completed at once
constexpr int tile = 48; ///< rows that a thread updates at once; their part of a panel stays in its cache
constexpr int row_padding = 16; ///< numbers; without them, rows of 2^k numbers would compete for cache lines
constexpr double least_pivot = 1e-14; ///< as a share of the largest entry of the diagonal

std::size_t stride_of(int size)
{
    return static_cast<std::size_t>((size + strip_width - 1) / strip_width * strip_width + row_padding);
}

/// row -= factor * other
void subtract(double* row, double factor, const double* other, int count)
{
    for (int j = 0; j < count; ++j)
        row[j] -= factor * other[j];
}

} // namespace

std::int64_t DenseCholesky::bytes(int size)
{
    return static_cast<std::int64_t>(size) * static_cast<std::int64_t>(stride_of(size)) * 8;
}

DenseCholesky::DenseCholesky(int size) : size_(size), stride_(stride_of(size))
{
    require_memory(bytes(size), "the dense factor");
    entries_.reserve(stride_ * static_cast<std::size_t>(size));
    ask_for_large_pages(entries_.data(), entries_.capacity() * sizeof(double));
    entries_.resize(stride_ * static_cast<std::size_t>(size));
}

int DenseCholesky::factorize(const Progress& progress, const char* stage)
{
    double largest = 0.0;
    for (int i = 0; i < size_; ++i)
        largest = std::max(largest, row(i)[i]);
    const DenseKernels& kernels = widest_kernels<DenseKernels>();
    // The panel's part of the rows below: turned, (rows, panel), and negated in strips for add_product.
    const std::size_t most = stride_ * panel;
    AlignedVector<double> turned(size_ > panel ? most : 0), packed(turned.size());
    const int stride = static_cast<int>(stride_);
    for (int begin = 0; begin < size_; begin += panel) {
        const double left = 1.0 - static_cast<double>(begin) / size_;
        progress.tick(1.0 - left * left * left, stage);
        const int end = std::min(begin + panel, size_), height = end - begin, width = size_ - end;
        for (int k = begin; k < end; ++k) {
            if (!(row(k)[k] > least_pivot * largest))
                return k;
            const double scale = 1.0 / std::sqrt(row(k)[k]);
            for (int j = k; j < end; ++j)
                row(k)[j] *= scale;
            for (int i = k + 1; i < end; ++i)
                subtract(row(i) + i, row(k)[i], row(k) + i, end - i);
        }
        parallel_chunks(width, 8 * strip_width, [&](int from, int to) {
            const int strips = (to - from + strip_width - 1) / strip_width;
            kernels.substitute(row(begin) + begin, stride, height, row(begin) + end + from, stride, strips);
            for (int k = 0; k < height; ++k)
                for (int i = from; i < from + strips * strip_width; ++i) { // beyond the matrix are zeros
                    const double entry = row(begin + k)[end + i];
                    turned[static_cast<std::size_t>(i) * height + k] = entry;
                    packed[static_cast<std::size_t>((i / strip_width * height + k) * strip_width +
                                                    i % strip_width)] = -entry;
                }
        });
        // The first rows are the longest, so each is a task.
        parallel_tasks((width + tile - 1) / tile, [&](int task) {
            const int from = tile * task, to = std::min(from + tile, width);
            kernels.add_product(turned.data() + static_cast<std::size_t>(from) * height, height, to - from,
                                height, packed.data() + static_cast<std::size_t>(from) * height,
                                (width - from + strip_width - 1) / strip_width, row(end + from) + end + from,
                                stride, nullptr);
        });
    }
    progress.tick(1.0, stage);
    return -1;
}

void DenseCholesky::solve(RowMatrix& x) const
{
    const int columns = static_cast<int>(x.cols());
    const auto line = [&](int i) { return x.data() + static_cast<std::size_t>(i) * columns; };
    for (int i = 0; i < size_; ++i) {
        const double scale = 1.0 / row(i)[i];
        for (int c = 0; c < columns; ++c)
            line(i)[c] *= scale;
        for (int j = i + 1; j < size_; ++j)
            subtract(line(j), row(i)[j], line(i), columns);
    }
    for (int i = size_ - 1; i >= 0; --i) {
        for (int j = i + 1; j < size_; ++j)
            subtract(line(i), row(i)[j], line(j), columns);
        const double scale = 1.0 / row(i)[i];
        for (int c = 0; c < columns; ++c)
            line(i)[c] *= scale;
    }
}

} // namespace sinew
