// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/dense/tall_products.h"

#include "native/core/parallel.h"
#include "native/solvers/dense/kernels.h"
#include "native/solvers/dense/system.h"

#include <algorithm>
#include <vector>

namespace sinew {

namespace {

constexpr int grain = 1024; ///< rows of a sum that one thread adds up
constexpr int inner = 256; ///< terms of a sum that are added up at once; their packed factor stays in a cache
constexpr int lines = 32; ///< rows that are turned from columns at once

Eigen::Index padded(Eigen::Index columns) { return (columns + strip_width - 1) / strip_width * strip_width; }

} // namespace

MatrixX transposed_product(const MatrixX& A, Eigen::Index columns, const MatrixX& B)
{
    const int rows = static_cast<int>(A.rows());
    std::vector<RowMatrix> sums(static_cast<std::size_t>((rows + grain - 1) / grain));
    parallel_chunks(rows, grain, [&](int first, int last) {
        RowMatrix& sum = sums[static_cast<std::size_t>(first / grain)];
        sum.setZero(columns, padded(B.cols()));
        for (int begin = first; begin < last; begin += inner) {
            const RowMatrix some = B.middleRows(begin, std::min(inner, last - begin));
            const PackedColumns packed(some.data(), static_cast<int>(some.rows()),
                                       static_cast<int>(some.cols()), static_cast<std::size_t>(some.cols()));
            packed.multiply_add(A.data() + begin, static_cast<int>(A.outerStride()),
                                static_cast<int>(columns), sum.data(), static_cast<int>(sum.cols()));
        }
    });
    MatrixX total = MatrixX::Zero(columns, B.cols());
    for (const RowMatrix& sum : sums)
        total += sum.leftCols(B.cols());
    return total;
}

void subtract_product(const MatrixX& A, Eigen::Index columns, const MatrixX& X, MatrixX& B)
{
    const RowMatrix turned = X;
    std::vector<PackedColumns> packed;
    for (Eigen::Index begin = 0; begin < columns; begin += inner)
        packed.emplace_back(turned.row(begin).data(),
                            static_cast<int>(std::min<Eigen::Index>(inner, columns - begin)),
                            static_cast<int>(turned.cols()), static_cast<std::size_t>(turned.cols()), -1.0);
    parallel_chunks(static_cast<int>(A.rows()), lines, [&](int begin, int end) {
        RowMatrix a(end - begin, columns), b(end - begin, padded(B.cols()));
        for (Eigen::Index k = 0; k < columns; ++k)
            for (int i = begin; i < end; ++i)
                a(i - begin, k) = A(i, k);
        b.leftCols(B.cols()) = B.middleRows(begin, end - begin);
        b.rightCols(b.cols() - B.cols()).setZero();
        for (std::size_t k = 0; k < packed.size(); ++k)
            packed[k].multiply_add(a.data() + inner * k, static_cast<int>(columns), end - begin, b.data(),
                                   static_cast<int>(b.cols()));
        B.middleRows(begin, end - begin) = b.leftCols(B.cols());
    });
}

} // namespace sinew
