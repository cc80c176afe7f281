// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/handles/propagation_kernels.h"

#include "tests/native/shapes.h"
#include "tests/native/wide_kernels.h"

namespace sinew::test_propagation_kernels {

TEST(PropagationKernels, give_the_same_bits_with_every_set_of_instructions)
{
    shapes::Random random(5);
    std::array<PropagatedMotion, 2> motions{};
    for (PropagatedMotion& motion : motions) {
        RowMatrix::Map(motion.numbers, 1, 9) = random.dense(1, 9);
        RowMatrix::Map(motion.centre, 1, 3) = random.dense(1, 3);
        RowMatrix::Map(motion.move, 1, 3) = random.dense(1, 3);
        motion.turning = 0.7;
    }
    PropagatedPart part{motions.data(), 2, {}, {1, 0, 0, 0, 0, -1, 0, 1, 0}};
    constexpr int points = 13, room = 16;
    RowMatrix t = random.dense(2, room);
    const RowMatrix from = random.dense(room, 3);
    const auto expect_same = [&](int first_left) {
        RowMatrix expected = RowMatrix::Zero(room, 3), to = expected;
        EXPECT_EQ(
            PropagationKernels::baseline.move(part, points, t.data(), room, from.data(), expected.data()),
            first_left);
        for (const PropagationKernels* kernels : wide_kernels<PropagationKernels>()) {
            EXPECT_EQ(kernels->move(part, points, t.data(), room, from.data(), to.data()), first_left);
            EXPECT_EQ(to.topRows(first_left), expected.topRows(first_left));
        }
    };
    expect_same(points);
    t.col(14).setConstant(40.0); // beyond the last point
    expect_same(points);
    for (const int left : {11, 6, 0}) {
        t.col(left).setConstant(40.0);
        expect_same(left);
    }
}

} // namespace sinew::test_propagation_kernels
