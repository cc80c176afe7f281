// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/splines/bspline_basis.h"

#include "native/core/errors.h"

#include <gtest/gtest.h>

#include <vector>

namespace sinew::test_bspline_basis {

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

// Its values are those of SciPy in tests/bindings/spaces/test_lattices.py and oracles/test_oracles_spline.py.
TEST(BsplineBasis, is_positive_within_its_support_and_reproduces_lines_by_the_places_of_its_coefficients)
{
    for (BsplineBasis::Ends ends : {BsplineBasis::Ends::uniform, BsplineBasis::Ends::clamped})
        for (int degree = 1; degree <= 5; ++degree)
            for (int count : {degree + 1, degree + 2, 10, 32}) {
                const BsplineBasis basis(degree, count, ends);
                for (int k = 0; k <= 1000; ++k) {
                    const double t = k / 1000.0;
                    const std::vector<double> values = all_values(basis, t);
                    double sum = 0.0, line = 0.0;
                    for (int i = 0; i < count; ++i) {
                        const auto [low, high] = basis.support(i);
                        if (t < low - 1e-12 || t > high + 1e-12) {
                            EXPECT_EQ(values[i], 0.0);
                        } else if (t > low + 1e-3 && t < high - 1e-3) {
                            EXPECT_GT(values[i], 0.0);
                        }
                        EXPECT_GE(values[i], 0.0);
                        sum += values[i];
                        line += basis.place(i) * values[i];
                    }
                    EXPECT_NEAR(sum, 1.0, 1e-14); // some roundings of numbers up to 1
                    EXPECT_NEAR(line, t, 1e-14);
                }
            }
    EXPECT_THROW(BsplineBasis(0, 4), InvalidOption);
    EXPECT_THROW(BsplineBasis(6, 8), InvalidOption);
    EXPECT_THROW(BsplineBasis(3, 3), InvalidOption);
}

} // namespace sinew::test_bspline_basis
