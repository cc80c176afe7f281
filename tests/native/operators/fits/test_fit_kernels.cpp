// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/fits/fit_kernels.h"

#include "native/operators/fits/rotation_fit.h"
#include "tests/native/shapes.h"
#include "tests/native/wide_kernels.h"

namespace sinew::test_fit_kernels {

using Rows = Eigen::Matrix<double, 12, 3, Eigen::RowMajor>;

TEST(FitKernels, fit_as_single_fits_do_and_with_the_same_bits_on_every_processor)
{
    shapes::Random random(1);
    for (int trial = 0; trial < 200; ++trial) {
        const Rows S = random.dense(12, 3);
        Rows expected;
        for (const FitKernels* kernels : every_kernels<FitKernels>()) {
            Rows R;
            EXPECT_EQ(kernels->fit(S.data(), R.data()), 15);
            if (kernels == &FitKernels::baseline)
                expected = R;
            EXPECT_EQ(R, expected);
        }
        for (int k = 0; k < 4; ++k) // slopes from 1e-3 leave 1e-13
            EXPECT_LT((expected.middleRows<3>(3 * k) - fit_rotation_svd(S.middleRows<3>(3 * k))).norm(),
                      1e-12);
    }
}

TEST(FitKernels, say_which_fits_are_not_safe)
{
    Rows S = Rows::Zero(), R;
    S.middleRows<3>(3) = Matrix3::Identity();
    S(6, 0) = 1.0; // of rank one
    S.middleRows<3>(9) = -Matrix3::Identity();
    EXPECT_EQ(FitKernels::baseline.fit(S.data(), R.data()), 0b0011);
    EXPECT_EQ(R.topRows<3>(), Matrix3(Matrix3::Identity())) << "of zero";
    EXPECT_LT((R.middleRows<3>(3) - Matrix3::Identity()).norm(), 1e-15);
}

} // namespace sinew::test_fit_kernels
