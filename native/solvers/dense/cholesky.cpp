// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/dense/cholesky.h"

#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/solvers/dense/kernels.h"
#include "native/solvers/dense/system.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sinew {

namespace {

constexpr int panel = 64;       ///< rows that are completed at once
constexpr int strip = 16;       ///< of these rows, which are solved for without products
constexpr int tile = 128;       ///< columns whose part of a panel stays in a cache
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
    entries_.resize(stride_ * static_cast<std::size_t>(size));
}

int DenseCholesky::factorize(const Progress& progress, const char* stage)
{
    double largest = 0.0;
    for (int i = 0; i < size_; ++i)
        largest = std::max(largest, row(i)[i]);
    AlignedVector<double> turned; // the panel's part of the rows below, (rows, panel)
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
        for (int first = begin; first < end; first += strip) {
            const int last = std::min(first + strip, end), before = first - begin, some = last - first;
            if (before > 0 && width > 0) { // the rows before, as a product
                std::vector<double> above(static_cast<std::size_t>(some * before));
                for (int k = 0; k < some; ++k)
                    for (int j = 0; j < before; ++j)
                        above[static_cast<std::size_t>(k * before + j)] = row(begin + j)[first + k];
                for (int at = 0; at < width; at += tile) {
                    const PackedColumns known(row(begin) + end + at, before, std::min(tile, width - at),
                                              stride_, -1.0);
                    known.multiply_add(above.data(), before, some, row(first) + end + at,
                                       static_cast<int>(stride_));
                }
            }
            parallel_chunks(width, 256, [&](int from, int to) {
                for (int k = first; k < last; ++k) {
                    double* const line = row(k) + end + from;
                    for (int j = first; j < k; ++j)
                        subtract(line, row(j)[k], row(j) + end + from, to - from);
                    const double scale = 1.0 / row(k)[k];
                    for (int j = 0; j < to - from; ++j)
                        line[j] *= scale;
                }
            });
        }
        turned.resize(static_cast<std::size_t>(width) * height);
        parallel_for(
            width,
            [&](int i) {
                for (int k = 0; k < height; ++k)
                    turned[static_cast<std::size_t>(i) * height + k] = row(begin + k)[end + i];
            },
            256);
        for (int first = 0; first < width; first += tile) {
            const int columns = std::min(tile, width - first);
            const PackedColumns packed(row(begin) + end + first, height, columns, stride_, -1.0);
            parallel_chunks(first + columns, 48, [&](int from, int to) {
                packed.multiply_add(turned.data() + static_cast<std::size_t>(from) * height, height,
                                    to - from, row(end + from) + end + first, static_cast<int>(stride_));
            });
        }
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
