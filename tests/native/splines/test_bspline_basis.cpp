// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/splines/bspline_basis.h"

#include "native/core/errors.h"

#include <gtest/gtest.h>

#include <vector>

namespace sinew::test_bspline_basis {

using Ends = BsplineBasis::Ends;

/// All functions at t.
std::vector<double> all_values(const BsplineBasis& basis, double t)
{
    std::vector<double> all(basis.count(), 0.0);
    std::vector<double> some(basis.degree() + 1);
    const int first = basis.values(t, some.data());
    for (int k = 0; k <= basis.degree(); ++k)
        all.at(first + k) = some[k];
    return all;
}

TEST(BsplineBasis, is_never_negative_and_sums_to_one)
{
    for (Ends ends : {Ends::uniform, Ends::clamped})
        for (int degree = 1; degree <= 5; ++degree)
            for (int count : {degree + 1, degree + 2, 11, 32}) {
                const BsplineBasis basis(degree, count, ends);
                for (int k = -3; k <= 1003; ++k) {
                    double sum = 0.0;
                    for (double value : all_values(basis, k / 1000.0)) {
                        EXPECT_GE(value, 0.0);
                        sum += value;
                    }
                    EXPECT_NEAR(sum, 1.0, 1e-14); // some roundings of numbers up to 1
                }
            }
}

TEST(BsplineBasis, is_zero_outside_of_its_support_and_nowhere_inside)
{
    for (Ends ends : {Ends::uniform, Ends::clamped})
        for (int degree = 1; degree <= 5; ++degree) {
            const BsplineBasis basis(degree, 10, ends);
            for (int k = 0; k <= 1000; ++k) {
                const double t = k / 1000.0;
                const std::vector<double> values = all_values(basis, t);
                for (int i = 0; i < basis.count(); ++i) {
                    const auto [low, high] = basis.support(i);
                    if (t < low - 1e-12 || t > high + 1e-12) {
                        EXPECT_EQ(values[i], 0.0);
                    } else if (t > low + 1e-3 && t < high - 1e-3) {
                        EXPECT_GT(values[i], 0.0);
                    }
                }
            }
            if (ends == Ends::uniform) {
                EXPECT_NEAR(basis.support(4)[1] - basis.support(4)[0], (degree + 1.0) / basis.spans(), 1e-15);
            }
        }
}

TEST(BsplineBasis, has_the_places_of_its_coefficients_where_lines_are_reproduced)
{
    for (Ends ends : {Ends::uniform, Ends::clamped})
        for (int degree = 1; degree <= 5; ++degree) {
            const BsplineBasis basis(degree, 12, ends);
            for (double t : {0.0, 0.123, 0.5, 0.871, 1.0}) {
                const std::vector<double> values = all_values(basis, t);
                double sum = 0.0;
                for (int i = 0; i < basis.count(); ++i)
                    sum += basis.place(i) * values[i];
                EXPECT_NEAR(sum, t, 1e-14);
            }
        }
}

TEST(BsplineBasis, of_one_clamped_span_is_that_of_bernstein)
{
    for (double t : {0.0, 0.3, 0.5, 1.0}) {
        const std::vector<double> values = all_values({3, 4, Ends::clamped}, t);
        const double s = 1 - t;
        for (const auto& [i, expected] : std::vector<std::pair<int, double>>{
                 {0, s * s * s}, {1, 3 * s * s * t}, {2, 3 * s * t * t}, {3, t * t * t}})
            EXPECT_NEAR(values[i], expected, 1e-15);
    }
}

TEST(BsplineBasis, refuses_other_degrees_and_too_few_functions)
{
    EXPECT_THROW(BsplineBasis(0, 4), InvalidOption);
    EXPECT_THROW(BsplineBasis(6, 8), InvalidOption);
    EXPECT_THROW(BsplineBasis(3, 3), InvalidOption);
}

} // namespace sinew::test_bspline_basis
