// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/native/methods/multiresolution/codings.h"

namespace sinew {

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(CodingContract);

TEST_P(CodingContract, a_base_that_rests_or_moves_rigidly_takes_its_details_along)
{
    const Study study(24);
    const auto coding = GetParam().make(study);
    const Points &fine = study.fine(), &base = study.base;
    ASSERT_GT(shapes::distance(fine, base), 0.2);
    EXPECT_LT(shapes::distance(bumps::detailed(*coding, fine, base, base), fine), GetParam().zero);
    for (double degrees : {40.0, 180.0, 290.0}) {
        const Pose pose = shapes::turn({1, -3, 2}, degrees, {1, 2, 3}, {5, -4, 6});
        EXPECT_LT(shapes::distance(bumps::detailed(*coding, fine, base, shapes::transformed(base, pose)),
                                   shapes::transformed(fine, pose)),
                  GetParam().rigid);
    }
    const bool similar =
        shapes::distance(bumps::detailed(*coding, fine, base, 2 * base), 2 * fine) < 10 * GetParam().rigid;
    EXPECT_EQ(similar, GetParam().similar);
}

TEST_P(CodingContract, another_shape_that_enters_comes_back_and_moves_rigidly)
{
    const Study study(16);
    const auto coding = GetParam().make(study);
    shapes::Random random(4);
    const Points entering =
        study.fine() * random.rotation() + 0.05 * random.dense(study.mesh.vertex_count(), 3);
    Points smooth;
    study.fairing.smooth(view(entering), smooth);
    EXPECT_LT(shapes::distance(bumps::detailed(*coding, entering, smooth, smooth), entering),
              GetParam().zero);
    const Pose pose = shapes::turn({1, 1, 2}, 100, {1, 2, 3}, {5, -4, 6});
    EXPECT_LT(shapes::distance(bumps::detailed(*coding, entering, smooth, shapes::transformed(smooth, pose)),
                               shapes::transformed(entering, pose)),
              GetParam().rigid);
}

TEST_P(CodingContract, bends_strain_the_edges_as_the_study_found)
{
    const Study study(60);
    const auto coding = GetParam().make(study);
    // Mixed areas and a border held on all four sides, which the study had not, change the third digit.
    for (const auto& [degrees, expected] :
         {std::pair{120.0, GetParam().bent_up}, {-120.0, GetParam().bent_down}}) {
        const Points moved = bumps::bent(study.base, degrees, 2, 8);
        const Points x = bumps::detailed(*coding, study.fine(), study.base, moved);
        EXPECT_NEAR(bumps::rms_edge_ratio(study.mesh, x), expected, 0.1 * expected) << degrees;
        EXPECT_EQ(bumps::turned_faces(study.mesh, study.base, moved, x), 0) << degrees;
    }
}

} // namespace sinew
