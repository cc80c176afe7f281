// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/dense/tall_products.h"

#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew {

TEST(TallProducts, equal_the_products_by_definition)
{
    shapes::Random random(3);
    for (const int rows : {1, 40, 1025, 5000})
        for (const int columns : {0, 1, 13, 300})
            for (const int k : {1, 8, 21}) {
                const MatrixX A = random.dense(rows, columns + 3), X = random.dense(columns, k);
                MatrixX B = random.dense(rows, k);
                // Rounding of sums of 5,000 products.
                EXPECT_LT((transposed_product(A, columns, B) - A.leftCols(columns).transpose() * B).norm(),
                          1e-11 * std::sqrt(1.0 * rows * k));
                const MatrixX expected = B - A.leftCols(columns) * X;
                subtract_product(A, columns, X, B);
                EXPECT_LT((B - expected).norm(), 1e-13 * std::sqrt(1.0 * rows * k) * (columns + 1));
            }
}

TEST(TallProducts, do_not_depend_on_the_number_of_threads)
{
    shapes::Random random(4);
    const MatrixX A = random.dense(9000, 70), X = random.dense(70, 20), B = random.dense(9000, 20);
    const MatrixX many = transposed_product(A, 70, B);
    MatrixX less = B;
    subtract_product(A, 70, X, less);
    const ThreadLimit limit(1);
    EXPECT_EQ(transposed_product(A, 70, B), many);
    MatrixX again = B;
    subtract_product(A, 70, X, again);
    EXPECT_EQ(again, less);
}

} // namespace sinew
