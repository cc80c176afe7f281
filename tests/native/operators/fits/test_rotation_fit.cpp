// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/fits/rotation_fit.h"

#include "tests/native/long_doubles.h"
#include "tests/native/shapes.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_rotation_fit {

namespace {

using LongMatrix3 = Eigen::Matrix<long double, 3, 3>;

/// The largest trace(R^T S) over rotations, from singular values in long double.
double best_trace(const Matrix3& S)
{
    const LongDoubles with_all_bits;
    const Eigen::JacobiSVD<LongMatrix3> svd(S.cast<long double>(), Eigen::ComputeFullU | Eigen::ComputeFullV);
    const auto sigma = svd.singularValues();
    // The determinant of a nearly singular S is rounding; that of two rotations is not.
    const bool reflected = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0;
    return static_cast<double>(sigma[0] + sigma[1] + (reflected ? -sigma[2] : sigma[2]));
}

double trace(const Matrix3& R, const Matrix3& S) { return (R.transpose() * S).trace(); }

void expect_best(const Matrix3& S)
{
    for (const Matrix3& R : {fit_rotation(S), fit_rotation_svd(S)}) {
        // A unit quaternion gives R to a few epsilon.
        EXPECT_LT((R * R.transpose() - Matrix3::Identity()).norm(), 1e-14) << S;
        EXPECT_NEAR(R.determinant(), 1.0, 1e-14) << S;
        // Exact to rounding of the sum of nine products.
        EXPECT_LE(best_trace(S) - trace(R, S), 1e-13 * S.norm()) << S;
    }
}

/// U diag(sigma) V^T with random rotations.
Matrix3 with_singular_values(shapes::Random& random, const Vector3& sigma)
{
    return random.rotation() * sigma.asDiagonal() * random.rotation().transpose();
}

} // namespace

TEST(RotationFit, is_optimal_for_random_matrices_of_either_sign)
{
    shapes::Random random(1);
    int reflected = 0;
    for (int trial = 0; trial < 20'000; ++trial) {
        const Matrix3 S = random.matrix();
        reflected += S.determinant() < 0;
        expect_best(S);
    }
    EXPECT_GT(reflected, 8'000);
}

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

TEST(RotationFit, is_optimal_where_singular_values_vanish_or_nearly_tie)
{
    shapes::Random random(5);
    for (double e : {0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 1e-2})
        for (const Vector3& sigma :
             {Vector3(1, e, e), Vector3(1, e, 0), Vector3(1, 1, e), Vector3(1, 1 + e, -1), Vector3(1, e, -e),
              Vector3(1, 0.5, -0.5 - e), Vector3(1, 0.5 + e, -0.5), Vector3(1, 1, -1 + e),
              Vector3(1, 1 + e, 1), Vector3(e, e, -e), Vector3(1, 0.3, e), Vector3(1, 0.3, -e)})
            for (int trial = 0; trial < 20; ++trial)
                expect_best(with_singular_values(random, sigma));
}

TEST(RotationFit, is_optimal_for_exact_rank_one_and_two_and_diagonal_matrices)
{
    shapes::Random random(6);
    for (int trial = 0; trial < 200; ++trial) {
        const Vector3 a = random.vector(), b = random.vector(), c = random.vector(), d = random.vector();
        expect_best(a * b.transpose());
        expect_best(a * b.transpose() + c * d.transpose());
    }
    for (double x : {-1.0, 0.0, 1.0})
        for (double y : {-1.0, 0.0, 1.0, 2.0})
            for (double z : {-1.0, 0.0, 1.0})
                expect_best(Vector3(x, y, z).asDiagonal());
}

TEST(RotationFit, of_nothing_is_the_identity)
{
    EXPECT_EQ(fit_rotation(Matrix3::Zero()), Matrix3::Identity());
}

TEST(RotationFit, does_not_mind_the_scale)
{
    shapes::Random random(7);
    for (double scale : {1e-140, 1e-50, 1e50, 1e140})
        for (int trial = 0; trial < 100; ++trial) {
            const Matrix3 S = random.matrix();
            // A power of ten is no power of two: rounding of S itself, over gaps down to 1e-3.
            EXPECT_LT((fit_rotation(scale * S) - fit_rotation(S)).norm(), 1e-10);
        }
}

TEST(RotationFit, of_a_reflection_turns_the_least_stretched_axis_back)
{
    // diag(3, 2, -1): the identity loses 1 on z; any other rotation loses more.
    EXPECT_LT((fit_rotation(Vector3(3, 2, -1).asDiagonal()) - Matrix3::Identity()).norm(), 1e-14);
}

} // namespace sinew::test_rotation_fit
