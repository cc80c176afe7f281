// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/lattice/grid/blend_kernels.h"

#include "tests/native/shapes.h"
#include "tests/native/wide_kernels.h"

#include <gtest/gtest.h>

#include <array>

namespace sinew::test_blend_kernels {

TEST(BlendKernels, all_give_the_same_bits)
{
    shapes::Random random(7);
    const MatrixX moves = random.dense(3, 16 * 16 * 16), local = random.dense(8, 3);
    for (const int width : {1, 2, 4, 5, 16}) {
        const MatrixX rows = random.dense(width * 6, 3);
        BlendCell cell{};
        for (int axis = 0; axis < 3; ++axis)
            cell.axes[axis] = {rows.col(axis).data(), width, 5};
        cell.moves = moves.data();
        cell.strides[0] = 48;
        cell.strides[1] = 768;
        std::array<double, 24> expected{}, found{};
        BlendKernels::baseline.blend(cell, local.data(), expected.data());
        for (const BlendKernels* kernels : wide_kernels<BlendKernels>()) {
            kernels->blend(cell, local.data(), found.data());
            EXPECT_EQ(found, expected) << width;
        }
    }
}

} // namespace sinew::test_blend_kernels
