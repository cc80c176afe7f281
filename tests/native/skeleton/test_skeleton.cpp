// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/skeleton/skeleton.h"

#include "tests/native/shapes.h"
#include "tests/native/skeleton/bodies.h"

#include <gtest/gtest.h>

namespace sinew::test_skeleton {

TEST(Skeleton, RestIsTheIdentity)
{
    const Skeleton skeleton = bodies::Figure().skeleton();
    for (const Pose& pose : skeleton.poses(skeleton.rest()))
        EXPECT_LT((pose - shapes::still()).norm(), 1e-14);
}

TEST(Skeleton, AHingeTurnsAboutItsOwnAxis)
{
    // A bone along y whose own axes are those of the world: turned by a right angle about x, it points along
    // z.
    Joint joint;
    joint.kind = Joint::Kind::angles;
    Points head = Points::Zero(1, 3), tail = Points::Zero(1, 3);
    tail(0, 1) = 2;
    const Skeleton skeleton(head, tail, {-1}, {Matrix3::Identity()}, {joint});
    Posture posture = skeleton.rest();
    posture.turns(0, 0) = shapes::pi / 2;
    EXPECT_LT((apply(skeleton.poses(posture)[0], {0, 2, 0}) - Vector3(0, 0, 2)).norm(), 1e-15);
}

// Other rotations are those of SciPy, and lengths and joints those of random skeletons, in
// tests/bindings/surfaces/test_mesh_puppetry.py.
TEST(Skeleton, WhereTwoAxesAreOneAPostureComesBackFromItsRotation)
{
    // There are many angles, and one of them is given.
    Joint joint;
    joint.kind = Joint::Kind::angles;
    const Skeleton one = bodies::chain(1, {joint});
    Posture posture = one.rest();
    posture.turns.row(0) << 0.4, shapes::pi / 2, -0.3;
    const std::vector<Matrix3> R = one.rotations(posture);
    EXPECT_LT((one.rotations(one.posture(R))[0] - R[0]).norm(), 1e-14);
}

} // namespace sinew::test_skeleton
