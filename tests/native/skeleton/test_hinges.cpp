// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/skeleton/hinges.h"

#include "tests/native/shapes.h"

namespace sinew::test_hinges {

/// A thigh, a calf that is bent back against it, to +y, by `bend`, and a foot; and the tails of another limb
/// that hangs on the thigh.
Skeleton leg(double bend, const Joint& knee = {}, const std::vector<Vector3>& limb = {})
{
    std::vector<Vector3> heads{{0, 0, 2}, {0, 0, 1}, {0, std::sin(bend), 1 - std::cos(bend)}};
    std::vector<Vector3> tails{heads[1], heads[2], heads[2] + Vector3(0, -0.5, 0)};
    std::vector<int> parents{-1, 0, 1};
    for (const Vector3& tail : limb) {
        parents.push_back(tail == limb[0] ? 0 : static_cast<int>(parents.size()) - 1);
        heads.push_back(tails[parents.back()]);
        tails.push_back(tail);
    }
    std::vector<Joint> joints(heads.size());
    joints[1] = knee;
    return {shapes::points_of(heads), shapes::points_of(tails), parents, {}, joints};
}

TEST(Hinges, AKneeBendsFurtherAboutItsHinge)
{
    const Skeleton skeleton = leg(0.2);
    const std::vector<Hinge> all = hinges(skeleton);
    EXPECT_FALSE(all[0]); // nothing that it could bend against
    ASSERT_TRUE(all[1]);
    EXPECT_LT((skeleton.axes(1) * all[1]->col(0) - Vector3::UnitX()).norm(), 1e-12);
    EXPECT_TRUE((all[1]->transpose() * *all[1]).isIdentity(1e-12));
    EXPECT_GT(all[1]->determinant(), 0);
    Posture posture = skeleton.rest();
    posture.turns.row(1) = 0.3 * all[1]->col(0).transpose();
    const Vector3 ankle = apply(skeleton.poses(posture)[1], skeleton.tail(1));
    EXPECT_LT((ankle - Vector3(0, std::sin(0.5), 1 - std::cos(0.5))).norm(), 1e-12);
    EXPECT_TRUE(all[2]); // the ankle
}

TEST(Hinges, WhoHasNone)
{
    Joint cone, angles;
    cone.most = 2.0;
    angles.kind = Joint::Kind::angles;
    EXPECT_FALSE(hinges(leg(0.0))[1]); // straight at rest
    EXPECT_FALSE(hinges(leg(1e-4))[1]);
    EXPECT_FALSE(hinges(leg(0.2, cone))[1]);
    EXPECT_FALSE(hinges(leg(0.2, angles))[1]);
    EXPECT_TRUE(hinges(leg(0.2, {}, {{1, 0, 1}}))[1]); // a helper that carries nothing is no limb
    EXPECT_FALSE(hinges(leg(0.2, {}, {{1, 0, 1}, {2, 0.3, 1}}))[1]); // two go on, as from a hip
}

} // namespace sinew::test_hinges
