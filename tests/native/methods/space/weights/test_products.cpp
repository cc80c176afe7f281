// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/weights/products.h"

#include "tests/native/shapes.h"
#include "tests/native/wide_kernels.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <vector>

namespace sinew::test_products {

namespace {

template <class T>
void expect_same_products(void (*ours)(const T*, int, const T*, T*),
                          void (*other)(const T*, int, const T*, T*))
{
    constexpr int points = 64 / sizeof(T);
    shapes::Random random(5);
    for (const int columns : {1, 63, 64, 65, 300}) {
        std::vector<T> block(points * columns), factors(3 * columns);
        for (T& b : block)
            b = static_cast<T>(random.signed_unit());
        for (T& f : factors)
            f = static_cast<T>(random.signed_unit());
        std::array<T, 3 * points> sums, others;
        ours(block.data(), columns, factors.data(), sums.data());
        other(block.data(), columns, factors.data(), others.data());
        EXPECT_EQ(sums, others);
        for (int axis = 0; axis < 3; ++axis)
            for (int i = 0; i < points; ++i) {
                double exact = 0.0;
                for (int c = 0; c < columns; ++c)
                    exact += static_cast<double>(block[points * c + i]) * factors[3 * c + axis];
                // 64 additions of sums up to 64, and as many of them as there are in the columns
                EXPECT_NEAR(sums[points * axis + i], exact, 64 * 64 * std::numeric_limits<T>::epsilon());
            }
    }
}

} // namespace

TEST(ProductKernels, products_agree_and_are_right)
{
    const ProductKernels& base = ProductKernels::baseline;
    for (const ProductKernels* kernels : every_kernels<ProductKernels>()) {
        expect_same_products(base.product_of_doubles, kernels->product_of_doubles);
        expect_same_products(base.product_of_floats, kernels->product_of_floats);
    }
}

TEST(ProductKernels, sparse_products_agree_and_are_right)
{
    const std::vector<double> weights{0.5, 0.25, 2.0, -1.0}, factors{1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0};
    const std::vector<int> columns{0, 2, 1, 1}, offsets{0, 3, 3, 4};
    const std::vector<double> exact{10.25, 13, 15.75, 0, 0, 0, 0, 0, -4, -5, -6, 0};
    std::vector<double> sums(12);
    for (const ProductKernels* kernels : every_kernels<ProductKernels>()) {
        kernels->sparse_product_of_doubles(weights.data(), columns.data(), offsets.data(), 3, factors.data(),
                                           sums.data());
        EXPECT_EQ(sums, exact);
    }
}

} // namespace sinew::test_products
