// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/skeleton/hinges.h"

#include "tests/native/skeleton/bodies.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace sinew::test_hinges {

namespace {

/// A thigh, a calf that is bent back against it, to +y, by `bend`, and a foot; and what else hangs on the
/// thigh.
Skeleton leg(double bend, const Joint& knee = {}, const std::vector<Vector3>& more = {})
{
    std::vector<Vector3> heads{{0, 0, 2}, {0, 0, 1}, {0, std::sin(bend), 1 - std::cos(bend)}};
    std::vector<Vector3> tails{heads[1], heads[2], heads[2] + Vector3(0, -0.5, 0)};
    std::vector<int> parents{-1, 0, 1};
    for (const Vector3& tail : more) {
        heads.push_back(heads[1]);
        tails.push_back(tail);
        parents.push_back(0);
    }
    std::vector<Joint> joints(heads.size());
    joints[1] = knee;
    return {shapes::points_of(heads), shapes::points_of(tails), parents, {}, joints};
}

} // namespace

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
    EXPECT_FALSE(hinges(leg(0.0))[1]); // straight at rest
    EXPECT_FALSE(hinges(leg(1e-4))[1]);
    Joint limited;
    limited.most = 2.0;
    EXPECT_FALSE(hinges(leg(0.2, limited))[1]);
    limited = {};
    limited.kind = Joint::Kind::angles;
    EXPECT_FALSE(hinges(leg(0.2, limited))[1]);
    EXPECT_TRUE(hinges(leg(0.2, {}, {{1, 0, 1}}))[1]); // a helper that carries nothing is no limb
    for (const Hinge& hinge : hinges(bodies::chain(4)))
        EXPECT_FALSE(hinge);
    const bodies::Figure figure;
    const std::vector<Hinge> all = hinges(figure.skeleton());
    for (int side = 0; side < 2; ++side) {
        const int shin = figure.parents[figure.foot[side]], thigh = figure.parents[shin],
                  pelvis = figure.parents[thigh];
        EXPECT_TRUE(all[shin]);
        EXPECT_TRUE(all[thigh]);
        EXPECT_FALSE(all[pelvis]); // the spine and two legs go on from the hip
    }
}

} // namespace sinew::test_hinges
