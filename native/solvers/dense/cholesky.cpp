// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/dense/cholesky.h"

#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/core/system/memory_advice.h"
#include "native/solvers/dense/kernels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>

namespace sinew {

namespace {

constexpr int panel = 96;       ///< rows that are completed at once
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
    AlignedVector<double> packed(size_ > panel ? stride_ * panel : 0); // the panel, negated, for add_product
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
                for (int i = from; i < from + strips * strip_width; ++i) // beyond the matrix are zeros
                    packed[static_cast<std::size_t>((i / strip_width * height + k) * strip_width +
                                                    i % strip_width)] = -row(begin + k)[end + i];
        });
        // The first rows are the longest, so each is a task.
        parallel_tasks((width + tile - 1) / tile, [&](int task) {
            const int from = tile * task, to = std::min(from + tile, width);
            kernels.add_product(row(begin) + end + from, 1, stride, to - from, height,
                                packed.data() + static_cast<std::size_t>(from) * height,
                                (width - from + strip_width - 1) / strip_width, row(end + from) + end + from,
                                stride, nullptr);
        });
    }
    progress.tick(1.0, stage);
    return -1;
}

void DenseCholesky::solve(RowMatrix& x) const
{
    const DenseKernels& kernels = widest_kernels<DenseKernels>();
    const int columns = static_cast<int>(x.cols()), stride = static_cast<int>(stride_);
    constexpr int w = strip_width; // columns that are solved for at once
    AlignedVector<double> strip(static_cast<std::size_t>(size_) * w), known(strip.size()); // known: negated
    const auto line = [&](int i) { return strip.data() + static_cast<std::size_t>(i) * w; };
    const auto negated = [&](int i) { return known.data() + static_cast<std::size_t>(i) * w; };
    for (int first = 0; first < columns; first += w) {
        const int some = std::min(w, columns - first);
        for (int i = 0; i < size_; ++i)
            for (int c = 0; c < w; ++c)
                line(i)[c] = c < some ? x(i, first + c) : 0.0;
        for (int begin = 0; begin < size_; begin += panel) {
            const int end = std::min(begin + panel, size_), height = end - begin;
            kernels.substitute(row(begin) + begin, stride, height, line(begin), w, 1);
            std::transform(line(begin), line(end), negated(begin), std::negate<>());
            parallel_chunks(size_ - end, 256, [&](int from, int to) {
                kernels.add_product(row(begin) + end + from, 1, stride, to - from, height, negated(begin), 1,
                                    line(end + from), w, nullptr);
            });
        }
        for (int begin = (size_ - 1) / panel * panel; begin >= 0; begin -= panel) {
            const int end = std::min(begin + panel, size_), width = size_ - end;
            parallel_chunks(end - begin, width > 1024 ? panel / 4 : panel, [&](int from, int to) {
                kernels.add_product(row(begin + from) + end, stride, 1, to - from, width, negated(end), 1,
                                    line(begin + from), w, nullptr);
            });
            for (int i = end - 1; i >= begin; --i) {
                for (int j = i + 1; j < end; ++j)
                    subtract(line(i), row(i)[j], line(j), w);
                const double scale = 1.0 / row(i)[i];
                for (int c = 0; c < w; ++c)
                    line(i)[c] *= scale;
            }
            std::transform(line(begin), line(end), negated(begin), std::negate<>());
        }
        for (int i = 0; i < size_; ++i)
            for (int c = 0; c < some; ++c)
                x(i, first + c) = line(i)[c];
    }
}

} // namespace sinew
