// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/space/space_order.h"

#include "tests/native/shapes.h"

namespace sinew::test_space_order {

TEST(SpaceOrder, codes_interleave_the_bits_of_the_coordinates)
{
    const Points points = shapes::Random(5).points(300);
    const Eigen::RowVector3d low = points.colwise().minCoeff();
    const double extent = (points.colwise().maxCoeff() - low).maxCoeff();
    const std::vector<std::uint64_t> codes = morton_codes(view(points));
    for (int i = 0; i < 300; ++i) {
        std::uint64_t expected = 0;
        for (int bit = 0; bit < 21; ++bit)
            for (int axis = 0; axis < 3; ++axis) {
                const auto cell =
                    static_cast<std::uint64_t>((points(i, axis) - low[axis]) / extent * ((1 << 21) - 1));
                expected |= (cell >> bit & 1) << (3 * bit + axis);
            }
        EXPECT_EQ(codes[i], expected);
    }
}

TEST(SpaceOrder, names_every_point_once_by_rising_code)
{
    const Points points = shapes::Random(5).points(20000);
    const std::vector<std::uint64_t> codes = morton_codes(view(points));
    std::vector<int> expected = shapes::numbers(0, 20000);
    std::ranges::stable_sort(expected, {}, [&](int i) { return codes[i] >> 33; });
    EXPECT_EQ(space_order(view(points)), expected);
    EXPECT_TRUE(space_order(view(Points(0, 3))).empty());
    EXPECT_EQ(space_order(view(Points(Points::Constant(3, 3, 7.0)))), (std::vector<int>{0, 1, 2}));
}

} // namespace sinew::test_space_order
