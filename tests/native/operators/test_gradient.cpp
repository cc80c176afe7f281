// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/gradient.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_gradient {

TEST(Gradient, is_zero_on_triangles_without_area)
{
    const SurfaceMesh mesh =
        shapes::mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 1, 3}});
    const MatrixX G = gradient_matrix(mesh);
    EXPECT_EQ(G.topRows(3).cwiseAbs().maxCoeff(), 0.0);
    EXPECT_GT(G.bottomRows(3).cwiseAbs().maxCoeff(), 0.5);
}

} // namespace sinew::test_gradient
