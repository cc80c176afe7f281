// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/simd/lane_math.inl"

#include "tests/native/shapes.h"
#include "tests/native/wide_kernels.h"

#include <limits>

namespace sinew::test_lane_math {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// Positive, of every size that may come up.
double positive(shapes::Random& random) { return std::exp(60.0 * random.signed_unit()); }

TEST(LaneMath, angles_are_those_of_the_c_library_to_two_units)
{
    shapes::Random random(1);
    for (int k = 0; k < 100'000; ++k) {
        const double y = positive(random), x = y * std::exp(8.0 * random.signed_unit());
        for (const double side : {x, -x, 0.0}) {
            const double exact = std::atan2(y, side);
            EXPECT_NEAR(angle_between(constant(y), constant(side))[2], exact, 2.0 * epsilon * exact);
            EXPECT_NEAR(angle_over_sine(constant(y), constant(side))[1] * y, exact, 4.0 * epsilon * exact);
        }
    }
    EXPECT_EQ(angle_between(constant(0.0), constant(2.0))[0], 0.0);
    EXPECT_EQ(angle_between(constant(0.0), constant(-2.0))[0], 3.141592653589793);
}

TEST(LaneMath, logarithms_are_those_of_the_c_library_to_two_units)
{
    shapes::Random random(2);
    for (int k = 0; k < 100'000; ++k) {
        const double a = positive(random), b = k % 2 ? positive(random) : a * (1.0 + random.unit());
        const double exact = static_cast<double>(std::log(static_cast<long double>(a) / b));
        EXPECT_NEAR(log_of_ratio(constant(a), constant(b))[3], exact,
                    2.0 * epsilon * (1.0 + std::abs(exact)));
    }
    EXPECT_EQ(log_of_ratio(constant(3.0), constant(3.0))[0], 0.0);
}

TEST(LaneMath, gives_the_same_bits_on_every_processor)
{
    shapes::Random random(3);
    std::vector<double> all;
    for (int k = 0; k < 1000; ++k) {
        const Lanes<double> y{random.unit(), random.unit(), random.unit(), random.unit()};
        const Lanes<double> x{random.signed_unit(), random.signed_unit(), random.unit(), -random.unit()};
        EXPECT_EQ(mask_bits(above(x, constant(0.0))) & 0b1100, 0b0100);
        for (const Lanes<double> result : {angle_between(y, x), angle_over_sine(y, x),
                                           log_of_ratio(y, magnitude(x)), root(y), signed_as(y, x)})
            for (int lane = 0; lane < 4; ++lane)
                all.push_back(result[lane]);
    }
    EXPECT_EQ(digest(all), 8726351490413920598ULL);
}

} // namespace sinew::test_lane_math
