// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/mean_value.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew {

TEST(MeanValue, has_the_known_weights_in_the_octahedron)
{
    MeanValue coordinates(Cage(shapes::octahedron()), {WeightPrecision::double_precision, 0.0});
    Points x(2, 3);
    x << 0.1, 0.2, 0.3, 0, 0, 0;
    coordinates.bind(view(x));
    RowMatrix expected(2, 6);
    expected << .18652452, .08652452, .26392439, .06392439, .34955109, .04955109, //
        1. / 6, 1. / 6, 1. / 6, 1. / 6, 1. / 6, 1. / 6;
    EXPECT_LT((coordinates.weights().dense() - expected).cwiseAbs().maxCoeff(), 5e-9); // the digits given
}

} // namespace sinew
