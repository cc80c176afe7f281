// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/substeps.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_substeps {

// What all methods do with them is in tests/bindings/surfaces/test_substeps.py.
TEST(Substeps, are_equal_parts_of_a_screw_and_of_a_scale)
{
    const Matrix3 S = Vector3(1.5, 0.8, 1.0).asDiagonal(), R = shapes::rotation({1, 2, -1}, 120);
    const Vector3 centre(4, 5, 6);
    const Pose rigid = shapes::affine(R, {1, 2, 3});
    const PathOfPoses path({rigid}, centre), elsewhere({rigid}, {-3, 1, 0});
    const Pose step = path.at(0.25)[0];
    Points p = shapes::hill(2, 2).points();
    for (int k = 1; k <= 4; ++k) {
        p = shapes::transformed(p, step);
        const Points expected = shapes::transformed(shapes::hill(2, 2).points(), path.at(k / 4.0)[0]);
        EXPECT_LT(shapes::distance(p, expected), 1e-12) << k;
        EXPECT_LT((path.at(k / 4.0)[0] - elsewhere.at(k / 4.0)[0]).norm(), 1e-12) << k;
    }
    EXPECT_LT((path.at(1.0)[0] - rigid).norm(), 1e-12);
    EXPECT_LT((path.at(0.0)[0] - shapes::still()).norm(), 1e-12);
    const Pose scaled = shapes::affine(R * S, {1, 2, 3});
    const PathOfPoses growing({scaled, shapes::shift(2, 4, 6)}, centre);
    EXPECT_LT((growing.at(1.0)[0] - scaled).norm(), 1e-12);
    EXPECT_LT(
        (growing.at(0.5)[0].leftCols<3>() - shapes::rotation({1, 2, -1}, 60) * (S + Matrix3::Identity()) / 2)
            .norm(),
        1e-12);
    EXPECT_LT((growing.at(0.5)[1] - shapes::shift(1, 2, 3)).norm(), 1e-12);
}

TEST(Substeps, of_a_half_turn_go_the_way_that_a_rule_chooses)
{
    for (double rounding : {-1e-15, 1e-15}) {
        const Pose pose =
            shapes::affine(shapes::rotation({0, 0, 1}, 180) * shapes::rotation({0, 0, 1}, rounding));
        const Pose middle = PathOfPoses({pose}, Vector3::Zero()).at(0.5)[0];
        EXPECT_LT((middle.leftCols<3>() - shapes::rotation({0, 0, 1}, 90)).norm(), 1e-9);
    }
}

} // namespace sinew::test_substeps
