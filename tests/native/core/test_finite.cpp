// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/finite.h"

#include <gtest/gtest.h>

#include <limits>

using namespace sinew;

TEST(Finite, finds_each_number_that_is_not_finite)
{
    using Limits = std::numeric_limits<double>;
    for (const int size : {1, 2, 3, 7, 8, 33}) {
        Eigen::VectorXd numbers = Eigen::VectorXd::LinSpaced(size, -1.0, 1.0);
        for (int at = 0; at < size; ++at) {
            for (const double number : {Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity()}) {
                Eigen::VectorXd with = numbers;
                with[at] = number;
                EXPECT_FALSE(all_finite(with)) << number << " at " << at << " of " << size;
            }
            numbers[at] = at % 2 ? Limits::denorm_min() : -Limits::max();
            EXPECT_TRUE(all_finite(numbers)) << at << " of " << size;
        }
    }
    EXPECT_TRUE(all_finite(Eigen::VectorXf()));
}
