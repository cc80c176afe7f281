// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/dense/cholesky.h"

#include "tests/native/dense.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

namespace sinew::test_cholesky {

DenseCholesky of(const MatrixX& A)
{
    DenseCholesky factor(static_cast<int>(A.rows()));
    for (int i = 0; i < A.rows(); ++i)
        for (int j = i; j < A.cols(); ++j)
            factor.row(i)[j] = A(i, j);
    return factor;
}

MatrixX definite(int size) { return dense::random_definite(size, size); }

TEST(DenseCholesky, solves_with_a_small_residual)
{
    shapes::Random random(1);
    for (const int size : {0, 1, 7, 96, 97, 331, 1301}) {
        const MatrixX A = definite(size), b = random.dense(size, 11);
        DenseCholesky factor = of(A);
        ASSERT_EQ(factor.factorize({}, "factorising"), -1);
        RowMatrix x = b;
        factor.solve(x);
        EXPECT_LE((dense::product(A, x) - b).norm(), 1e-14 * A.norm() * x.norm()) << size;
    }
}

TEST(DenseCholesky, tells_where_a_matrix_is_not_positive_definite)
{
    MatrixX A = definite(150);
    A(100, 100) = -1.0;
    DenseCholesky factor = of(A);
    EXPECT_EQ(factor.factorize({}, "factorising"), 100);
}

TEST(DenseCholesky, gives_the_same_bits_on_any_number_of_threads)
{
    const MatrixX A = definite(1300);
    const auto solved = [&] {
        DenseCholesky factor = of(A);
        factor.factorize({}, "factorising");
        RowMatrix x = RowMatrix::Ones(1300, 3);
        factor.solve(x);
        return x;
    };
    const RowMatrix all = solved();
    for (const int threads : {1, 3}) {
        const ThreadLimit limit(threads);
        EXPECT_EQ(solved(), all);
    }
}

TEST(DenseCholesky, refuses_what_takes_more_memory_than_allowed)
{
    const MemoryLimit limit(1000);
    EXPECT_THROW(DenseCholesky(100), OutOfMemory);
}

} // namespace sinew::test_cholesky
