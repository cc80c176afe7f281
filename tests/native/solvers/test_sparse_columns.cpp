// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/sparse_columns.h"

#include "tests/native/solvers/matrices.h"

namespace sinew::test_sparse_columns {

TEST(SparseColumns, product_is_that_of_dense_matrices_and_symmetric_to_the_bit)
{
    const SparseMatrix A = matrices::random_spd(40, 1), B = matrices::random_spd(40, 2);
    const VectorX d = VectorX::Random(40);
    const SparseMatrix product = sparse_product(A, d, B), square = sparse_product(A, d, A);
    const MatrixX expected = MatrixX(A) * d.asDiagonal() * MatrixX(B);
    EXPECT_LT((MatrixX(product) - expected).cwiseAbs().maxCoeff(), 1e-12); // 40 terms of order 10
    EXPECT_EQ((square - SparseMatrix(square.transpose())).norm(), 0.0);
}

TEST(SparseColumns, many_strips_are_put_together_in_order)
{
    EXPECT_EQ(sparse_by_columns(5, 5, [](int, SparseColumn&) {}).nonZeros(), 0);
    const int n = 40'000; // twenty strips
    const SparseMatrix A = sparse_by_columns(n, n, [&](int c, SparseColumn& column) {
        column.add((c + 7) % n, 1.0);
        column.add(c, c);
        column.add((c + 7) % n, 0.5);
    });
    ASSERT_EQ(A.nonZeros(), 2 * n);
    for (int c = 0; c < n; ++c) {
        EXPECT_EQ(A.coeff(c, c), c);
        EXPECT_EQ(A.coeff((c + 7) % n, c), 1.5);
    }
}

} // namespace sinew::test_sparse_columns
