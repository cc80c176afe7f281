// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/sampling.h"

#include <gtest/gtest.h>

namespace sinew::test_sampling {

TEST(FarthestPoints, are_far_from_all_before_and_never_coincide)
{
    const std::vector<Vector3> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {7, 0, 0}, {7, 0, 0}};
    EXPECT_EQ(farthest_points(line, 3, 0), (std::vector{0, 3, 2}));
    EXPECT_EQ(farthest_points(line, 9, 1), (std::vector{1, 3, 0, 2}));
    EXPECT_EQ(farthest_points(line, 1, 4), (std::vector{4}));
}

} // namespace sinew::test_sampling
