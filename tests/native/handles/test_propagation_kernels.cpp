// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/handles/propagation_kernels.h"

#include "tests/native/shapes.h"
#include "tests/native/wide_kernels.h"

#include <gtest/gtest.h>

#include <array>

namespace sinew {

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
    const RowMatrix t = random.dense(2, 4), from = random.dense(4, 3);
    RowMatrix expected(4, 3), to(4, 3);
    EXPECT_TRUE(PropagationKernels::baseline.move(part, t.data(), from.data(), expected.data()));
    for (const PropagationKernels* kernels : wide_kernels<PropagationKernels>()) {
        EXPECT_TRUE(kernels->move(part, t.data(), from.data(), to.data()));
        EXPECT_EQ(to, expected);
    }
    motions[0].numbers[0] = 40.0;
    EXPECT_FALSE(PropagationKernels::baseline.move(part, t.data(), from.data(), to.data()));
}

} // namespace sinew
