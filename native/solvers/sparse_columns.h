// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/parallel.h"
#include "native/core/types.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace sinew {

/// One column of a sparse matrix as it grows. Values added to the same row are summed in the order they came.
class SparseColumn
{
public:
    explicit SparseColumn(int rows) : slot_(rows, -1) {}

    void add(int row, double value)
    {
        int& slot = slot_[row];
        if (slot < 0) {
            slot = static_cast<int>(rows_.size());
            rows_.push_back(row);
            values_.push_back(value);
        } else {
            values_[slot] += value;
        }
    }

    /// Appends the entries by rising row, and starts anew.
    void move_to(std::vector<int>& rows, std::vector<double>& values)
    {
        std::sort(rows_.begin(), rows_.end());
        for (const int row : rows_) {
            rows.push_back(row);
            values.push_back(values_[slot_[row]]);
            slot_[row] = -1;
        }
        rows_.clear();
        values_.clear();
    }

private:
    std::vector<int> slot_; ///< of each row, -1 where there is no entry
    std::vector<int> rows_;
    std::vector<double> values_;
};

/// A sparse matrix whose column c is what body(c, column) adds; the columns are made in parallel.
template <class Body>
SparseMatrix sparse_by_columns(int rows, int columns, Body&& body)
{
    struct Strip
    {
        int begin = 0;
        std::vector<int> rows;
        std::vector<double> values;
    };
    constexpr int fewest = 2048, most_strips = 16;
    const int width = std::max(fewest, (columns + most_strips - 1) / most_strips);
    std::vector<Strip> strips((columns + width - 1) / width);
    SparseMatrix matrix(rows, columns);
    int* offsets = matrix.outerIndexPtr();
    parallel_chunks(columns, width, [&](int begin, int end) {
        Strip& strip = strips[begin / width];
        SparseColumn column(rows);
        for (int c = begin; c < end; ++c) {
            body(c, column);
            column.move_to(strip.rows, strip.values);
            if (c == begin + (end - begin) / 8) { // the rest will be alike: grow once
                const std::size_t likely = 9 * (strip.rows.size() + 16);
                strip.rows.reserve(likely);
                strip.values.reserve(likely);
            }
            offsets[c + 1] = static_cast<int>(strip.rows.size()); // within the strip
        }
    });
    int total = 0;
    for (std::size_t k = 0; k < strips.size(); ++k) {
        strips[k].begin = total;
        for (int c = static_cast<int>(k) * width; c < std::min(columns, static_cast<int>(k + 1) * width); ++c)
            offsets[c + 1] += total;
        total += static_cast<int>(strips[k].rows.size());
    }
    matrix.resizeNonZeros(total);
    parallel_chunks(static_cast<int>(strips.size()), 1, [&](int k, int) {
        Strip strip = std::move(strips[k]);
        std::copy(strip.rows.begin(), strip.rows.end(), matrix.innerIndexPtr() + strip.begin);
        std::copy(strip.values.begin(), strip.values.end(), matrix.valuePtr() + strip.begin);
    });
    return matrix;
}

/// A diag(d) B, the columns in parallel. Exactly symmetric where A = B is.
inline SparseMatrix sparse_product(const SparseMatrix& A, const VectorX& d, const SparseMatrix& B)
{
    return sparse_by_columns(
        static_cast<int>(A.rows()), static_cast<int>(B.cols()), [&](int c, SparseColumn& column) {
            for (SparseMatrix::InnerIterator b(B, c); b; ++b)
                for (SparseMatrix::InnerIterator a(A, static_cast<int>(b.row())); a; ++a)
                    column.add(static_cast<int>(a.row()), d[b.row()] * (a.value() * b.value()));
        });
}

} // namespace sinew
