// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/simd/product_of_eight.h"

#include "native/core/types.h"
#include "tests/native/wide_kernels.h"

#include <gtest/gtest.h>

namespace sinew::test_product_of_eight {

TEST(ProductOfEight, has_the_same_bits_with_wide_instructions)
{
    for (const int columns : {1, 2, 3, 4, 7, 16}) {
        const MatrixX eight = MatrixX::Random(8, 3 + columns), factors = MatrixX::Random(3, columns);
        MatrixX c(8, 3), d(8, 3);
        ProductOfEight::baseline.multiply(eight.data(), columns, factors.data(), c.data());
        for (const ProductOfEight* wide : wide_kernels<ProductOfEight>()) {
            wide->multiply(eight.data(), columns, factors.data(), d.data());
            EXPECT_EQ(c, d);
        }
        EXPECT_LT((c - (eight.leftCols(3) + eight.rightCols(columns) * factors.transpose())).norm(), 1e-13);
    }
}

} // namespace sinew::test_product_of_eight
