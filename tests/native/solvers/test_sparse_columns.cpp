// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/sparse_columns.h"

#include "tests/native/solvers/matrices.h"

namespace sinew::test_sparse_columns {

TEST(SparseColumns, product_is_that_of_dense_matrices)
{
    const SparseMatrix A = matrices::random_spd(40, 1), B = matrices::random_spd(40, 2);
    const VectorX d = VectorX::Random(40);
    const SparseMatrix product = sparse_product(A, d, B);
    const MatrixX expected = MatrixX(A) * d.asDiagonal() * MatrixX(B);
    EXPECT_LT((MatrixX(product) - expected).cwiseAbs().maxCoeff(), 1e-12); // 40 terms of order 10
}

TEST(SparseColumns, many_strips_are_put_together_in_order)
{
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

TEST(SparseColumns, product_with_itself_is_symmetric_to_the_bit)
{
    const SparseMatrix L = matrices::shuffled_grid(70, 0.1);
    const SparseMatrix A = sparse_product(L, VectorX::Random(L.cols()), L);
    EXPECT_EQ((A - SparseMatrix(A.transpose())).norm(), 0.0);
}

TEST(SparseColumns, of_nothing_are_an_empty_matrix)
{
    EXPECT_EQ(sparse_by_columns(0, 0, [](int, SparseColumn&) {}).nonZeros(), 0);
    EXPECT_EQ(sparse_by_columns(5, 5, [](int, SparseColumn&) {}).nonZeros(), 0);
}

} // namespace sinew::test_sparse_columns
