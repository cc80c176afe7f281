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

} // namespace sinew::test_displacement_vectors
