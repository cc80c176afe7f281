// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/frames/enclosing_ball.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_enclosing_ball {

TEST(EnclosingBall, holds_all_points_and_is_the_smallest)
{
    EXPECT_NEAR(enclosing_ball(shapes::cube().points()).radius, std::sqrt(0.75), 1e-12);
    EXPECT_NEAR(enclosing_ball(shapes::quad_grid(4, 3).points()).radius, 2.5, 1e-12);
    EXPECT_EQ(enclosing_ball(shapes::points_of({{3, 4, 5}})).radius, 0.0);
    EXPECT_EQ(enclosing_ball(shapes::points_of({{3, 4, 5}, {3, 4, 5}})).radius, 0.0);
    shapes::Random random(3);
    for (int trial = 0; trial < 20; ++trial) {
        const Points points = random.points(40);
        const Ball ball = enclosing_ball(points);
        int touching = 0;
        for (int i = 0; i < points.rows(); ++i) {
            const Vector3 arm = points.row(i).transpose() - ball.centre;
            EXPECT_LE(arm.norm(), ball.radius * (1 + 1e-9));
            touching += arm.norm() > ball.radius * (1 - 1e-9) ? 1 : 0;
        }
        EXPECT_GE(touching, 2);
        for (const Vector3& step : {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1)})
            for (const double by : {-1e-3, 1e-3}) // no ball around a centre nearby is smaller
                EXPECT_GT(
                    (points.rowwise() - (ball.centre + by * step).transpose()).rowwise().norm().maxCoeff(),
                    ball.radius);
    }
}

} // namespace sinew::test_enclosing_ball
