// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/skeleton/skeleton.h"

#include "tests/native/refusals.h"
#include "tests/native/shapes.h"
#include "tests/native/skeleton/bodies.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sinew::test_skeleton {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Posture random_posture(const Skeleton& skeleton, int seed)
{
    shapes::Random random(seed);
    Posture posture = skeleton.rest();
    for (double& turn : posture.turns.reshaped())
        turn = 1.5 * random.signed_unit();
    for (int b = 0; b < skeleton.bone_count(); ++b)
        if (skeleton.parent(b) < 0)
            posture.moves.row(b) = random.vector().transpose();
    return posture;
}

} // namespace

TEST(Skeleton, RestIsTheIdentity)
{
    const Skeleton skeleton = bodies::Figure().skeleton();
    for (const Pose& pose : skeleton.poses(skeleton.rest()))
        EXPECT_LT((pose - shapes::still()).norm(), 1e-14);
}

TEST(Skeleton, LengthsAndJointsAreExact)
{
    const bodies::Figure figure;
    const Skeleton skeleton = figure.skeleton(figure.joints());
    for (int seed = 0; seed < 20; ++seed) {
        const Poses poses = skeleton.poses(random_posture(skeleton, seed));
        for (int b = 0; b < skeleton.bone_count(); ++b) {
            const Vector3 head = apply(poses[b], skeleton.head(b)), tail = apply(poses[b], skeleton.tail(b));
            EXPECT_NEAR((tail - head).norm(), (skeleton.tail(b) - skeleton.head(b)).norm(), 1e-12);
            if (skeleton.parent(b) >= 0) {
                EXPECT_LT((head - apply(poses[skeleton.parent(b)], skeleton.head(b))).norm(), 1e-12);
            }
        }
    }
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

TEST(Skeleton, AnglesComeInTheOrderOfTheJoint)
{
    Joint joint;
    joint.kind = Joint::Kind::angles;
    const Vector3 angles(0.3, -0.7, 1.1);
    const auto about = [&](int axis) {
        return Eigen::AngleAxisd(angles[axis], Vector3::Unit(axis)).toRotationMatrix();
    };
    for (const auto& order : {std::array{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}) {
        joint.order = order;
        EXPECT_LT((rotation_of(joint, angles) - about(order[2]) * about(order[1]) * about(order[0])).norm(),
                  1e-15);
        const Skeleton skeleton = bodies::chain(1, {joint});
        Posture posture = skeleton.rest();
        posture.turns.row(0) = angles.transpose();
        const Posture back = skeleton.posture(skeleton.rotations(posture));
        EXPECT_LT((back.turns - posture.turns).norm(), 1e-14);
    }
}

TEST(Skeleton, PosturesComeBackFromTheirRotations)
{
    const bodies::Figure figure;
    const Skeleton skeleton = figure.skeleton(figure.joints());
    for (int seed = 0; seed < 10; ++seed) {
        const Posture posture = random_posture(skeleton, seed);
        const std::vector<Matrix3> rotations = skeleton.rotations(posture);
        const std::vector<Matrix3> again = skeleton.rotations(skeleton.posture(rotations));
        for (int b = 0; b < skeleton.bone_count(); ++b)
            EXPECT_LT((again[b] - rotations[b]).norm(), 1e-13);
    }
    // Where two axes of angles are one, there are many angles, and one of them is given.
    Joint joint;
    joint.kind = Joint::Kind::angles;
    const Skeleton one = bodies::chain(1, {joint});
    Posture posture = one.rest();
    posture.turns.row(0) << 0.4, shapes::pi / 2, -0.3;
    const std::vector<Matrix3> R = one.rotations(posture);
    EXPECT_LT((one.rotations(one.posture(R))[0] - R[0]).norm(), 1e-14);
}

TEST(Skeleton, Refusals)
{
    const Points none(0, 3), one = Points::Zero(1, 3);
    Points up = Points::Zero(1, 3);
    up(0, 2) = 1;
    EXPECT_STREQ(refusal<InvalidConstraint>([&] { Skeleton(none, none, {}); }).what(),
                 "the skeleton has no bones");
    refusal<InvalidConstraint>([&] { Skeleton(one, up, {-1, 0}); });
    refusal<InvalidConstraint>([&] { Skeleton(one, one, {-1}); }); // no length
    refusal<InvalidConstraint>([&] { Skeleton(one, up, {0}); });
    refusal<InvalidConstraint>([&] { Skeleton(one, up, {-2}); });
    refusal<InvalidConstraint>([&] { Skeleton(one, up, {-1}, {2 * Matrix3::Identity()}); });
    refusal<InvalidConstraint>([&] { Skeleton(one, up, {-1}, {-Matrix3::Identity()}); });
    Points lost = up;
    lost(0, 0) = nan;
    refusal<InvalidConstraint>([&] { Skeleton(one, lost, {-1}); });
    Joint joint;
    joint.lower[1] = 1;
    joint.upper[1] = 0;
    EXPECT_STREQ(refusal<InvalidOption>([&] { Skeleton(one, up, {-1}, {}, {joint}); }).what(),
                 "bone 0: the lower limit about y is above the upper one");
    joint = {};
    joint.most = -1;
    refusal<InvalidOption>([&] { Skeleton(one, up, {-1}, {}, {joint}); });
    joint = {};
    joint.order = {0, 0, 1};
    refusal<InvalidOption>([&] { Skeleton(one, up, {-1}, {}, {joint}); });
    joint = {};
    joint.stiffness = 0;
    refusal<InvalidOption>([&] { Skeleton(one, up, {-1}, {}, {joint}); });
    const Skeleton skeleton(one, up, {-1});
    refusal<InvalidConstraint>([&] { skeleton.poses({Points::Zero(2, 3), Points::Zero(2, 3)}); });
    refusal<InvalidConstraint>([&] { skeleton.posture({Matrix3::Zero()}); });
}

} // namespace sinew::test_skeleton
