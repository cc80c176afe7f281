// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/details/displacement_vectors.h"

#include "tests/native/methods/multiresolution/codings.h"

namespace sinew::test_displacement_vectors {

namespace {

CodingTraits traits()
{
    return {.name = "DisplacementVectors",
            .make =
                [](const Study& study) {
                    return std::make_unique<DisplacementVectors>(study.rings, view(study.base));
                },
            .bent_up = 0.0179,
            .bent_down = 0.0185};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(DisplacementVectors, CodingContract, testing::Values(traits()));

TEST(DisplacementVectors, keep_their_lengths)
{
    const Study study(20);
    shapes::Random random(2);
    const Points moved = 3 * study.base + random.dense(static_cast<int>(study.base.rows()), 3);
    const Points x =
        bumps::detailed(DisplacementVectors(study.rings, view(study.base)), study.fine(), study.base, moved);
    for (int v = 0; v < x.rows(); ++v)
        EXPECT_NEAR((x.row(v) - moved.row(v)).norm(), (study.fine().row(v) - study.base.row(v)).norm(),
                    1e-14);
}

} // namespace sinew::test_displacement_vectors
