// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/fits/rotation_fit.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_rotation_fit {

TEST(RotationFit, of_a_rotation_is_that_rotation)
{
    shapes::Random random(3);
    for (int trial = 0; trial < 1'000; ++trial) {
        const Matrix3 R = random.rotation();
        EXPECT_LT((fit_rotation(R) - R).norm(), 1e-13); // the safe path is not needed: sigma are well apart
        EXPECT_LT((fit_rotation(7.5 * R) - R).norm(), 1e-13);
    }
    const Vector3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    for (const Vector3& axis : axes)
        for (double angle : {1e-9, 90.0, 179.999999, 180.0}) {
            const Matrix3 R = shapes::rotation(axis, angle);
            EXPECT_LT((fit_rotation(R) - R).norm(), 1e-13) << axis.transpose() << " by " << angle;
        }
}

TEST(RotationFit, of_the_rotation_in_a_stretch_is_exact)
{
    shapes::Random random(4);
    for (int trial = 0; trial < 1'000; ++trial) {
        const Matrix3 R = random.rotation(), Q = random.rotation();
        const Vector3 stretch(1 + random.unit(), 1 + random.unit(), 1 + random.unit());
        const Matrix3 S = R * Q * stretch.asDiagonal() * Q.transpose();
        EXPECT_LT((fit_rotation(S) - R).norm(), 1e-13);
    }
}

TEST(RotationFit, of_nothing_is_the_identity)
{
    EXPECT_EQ(fit_rotation(Matrix3::Zero()), Matrix3::Identity());
}

TEST(RotationFit, of_a_reflection_turns_the_least_stretched_axis_back)
{
    // diag(3, 2, -1): the identity loses 1 on z; any other rotation loses more.
    EXPECT_LT((fit_rotation(Vector3(3, 2, -1).asDiagonal()) - Matrix3::Identity()).norm(), 1e-14);
}

} // namespace sinew::test_rotation_fit
