// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/parallel.h"
#include "native/core/types.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace sinew {

/// A column of a sparse matrix while it is assembled. Values for the same row are summed in the order of the
/// calls.
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

    int count() const { return static_cast<int>(rows_.size()); }

    /// Writes count() entries by rising row, and clears the column.
    void move_to(int* rows, double* values)
    {
        std::sort(rows_.begin(), rows_.end());
        for (const int row : rows_) {
            *rows++ = row;
            *values++ = values_[slot_[row]];
        }
        clear();
    }

    void clear()
    {
        for (const int row : rows_)
            slot_[row] = -1;
        rows_.clear();
        values_.clear();
    }

private:
    std::vector<int> slot_; ///< where the entry of each row is, or -1
    std::vector<int> rows_;
    std::vector<double> values_;
};

/// A sparse matrix whose column c has the entries that body(c, column) adds; the columns are assembled in
/// parallel. The body runs twice, first to count and then to fill, which needs less memory than keeping a
/// copy of all columns.
template <class Body>
SparseMatrix sparse_by_columns(int rows, int columns, Body&& body)
{
    constexpr int fewest = 2048, most_strips = 16; // each strip has a slot for every row
    const int width = std::max(fewest, (columns + most_strips - 1) / most_strips);
    SparseMatrix matrix(rows, columns);
    int* offsets = matrix.outerIndexPtr();
    parallel_chunks(columns, width, [&](int begin, int end) {
        SparseColumn column(rows);
        for (int c = begin; c < end; ++c) {
            body(c, column);
            offsets[c + 1] = column.count();
            column.clear();
        }
    });
    std::partial_sum(offsets, offsets + columns + 1, offsets);
    matrix.resizeNonZeros(offsets[columns]);
    parallel_chunks(columns, width, [&](int begin, int end) {
        SparseColumn column(rows);
        for (int c = begin; c < end; ++c) {
            body(c, column);
            column.move_to(matrix.innerIndexPtr() + offsets[c], matrix.valuePtr() + offsets[c]);
        }
    });
    return matrix;
}

/// A diag(d) B, with the columns in parallel. If A = B is symmetric, the product is exactly symmetric.
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
