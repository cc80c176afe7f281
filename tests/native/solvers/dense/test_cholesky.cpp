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

TEST(DenseCholesky, solves_with_a_small_residual_or_tells_where_it_cannot)
{
    MatrixX indefinite = dense::random_definite(150, 150);
    indefinite(100, 100) = -1.0;
    EXPECT_EQ(of(indefinite).factorize({}, "factorising"), 100);
    shapes::Random random(1);
    for (const int size : {0, 1, 7, 96, 97, 331, 1301}) {
        const MatrixX A = dense::random_definite(size, size), b = random.dense(size, 11);
        DenseCholesky factor = of(A);
        ASSERT_EQ(factor.factorize({}, "factorising"), -1);
        RowMatrix x = b;
        factor.solve(x);
        EXPECT_LE((dense::product(A, x) - b).norm(), 1e-14 * A.norm() * x.norm()) << size;
    }
}

TEST(DenseCholesky, gives_the_same_bits_on_any_number_of_threads_within_the_memory_limit)
{
    const MatrixX A = dense::random_definite(1300, 1300);
    const auto solved = [&] {
        DenseCholesky factor = of(A);
        factor.factorize({}, "factorising");
        RowMatrix x = RowMatrix::Ones(1300, 3);
        factor.solve(x);
        return x;
    };
    const RowMatrix all = solved();
    {
        const MemoryLimit limit(1000);
        EXPECT_THROW(DenseCholesky(100), OutOfMemory);
    }
    for (const int threads : {1, 3}) {
        const ThreadLimit limit(threads);
        EXPECT_EQ(solved(), all);
    }
}

} // namespace sinew::test_cholesky
