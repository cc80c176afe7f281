// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/subdivision/limit_masks.h"

#include "tests/native/shapes.h"

// A surface takes masks of its own where it is sharp for a while alone; elsewhere it has those of OpenSubdiv. Both
// are in tests/bindings/surfaces/test_subdivision.py, and here its own where their values are known.
namespace sinew::test_limit_masks {

// E. Halstead et al. 1993 for quads, C. Loop 1987 for triangles.
TEST(LimitMasks, are_the_published_ones_where_nothing_is_sharp)
{
    for (int n : {3, 4, 5, 8}) {
        const auto quads = limit_mask({false, n, 0.0, std::vector<double>(n, 0.0)});
        ASSERT_EQ(quads.size(), 1u + 2 * n);
        EXPECT_NEAR(quads[0], n / (n + 5.0), 1e-13);
        EXPECT_NEAR(quads[1], 4.0 / (n * (n + 5.0)), 1e-13);
        EXPECT_NEAR(quads[1 + n], 1.0 / (n * (n + 5.0)), 1e-13);

        const auto triangles = limit_mask({true, n, 0.0, std::vector<double>(n, 0.0)});
        const double c = 0.375 + 0.25 * std::cos(2 * shapes::pi / n), beta = (0.625 - c * c) / n;
        ASSERT_EQ(triangles.size(), 1u + n);
        EXPECT_NEAR(triangles[0], 1.0 / (1.0 + 8.0 * n * beta / 3.0), 1e-13);
    }
}

TEST(LimitMasks, of_creases_borders_and_corners_are_those_of_curves)
{
    const std::vector<double> crease{10, 0, 10, 0};
    EXPECT_EQ(limit_mask({true, 4, 0.0, crease}), (std::vector<double>{2. / 3, 1. / 6, 0, 1. / 6, 0}));
    const auto border = limit_mask({false, 2, 0.0, {10, 0, 10}});
    EXPECT_NEAR(border[0], 2.0 / 3, 1e-15);
    EXPECT_NEAR(border[1] + border[3], 1.0 / 3, 1e-15);
    EXPECT_EQ(limit_mask({false, 4, 10.0, {0, 0, 0, 0}})[0], 1.0);
    EXPECT_EQ(limit_mask({false, 4, 0.0, {10, 10, 10, 0}})[0], 1.0);
}

} // namespace sinew::test_limit_masks
