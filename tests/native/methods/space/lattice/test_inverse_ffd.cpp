// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/lattice/inverse_ffd.h"

#include "tests/native/methods/space/contract.h"
#include "tests/native/methods/space/lattice/lattices.h"

#include <gtest/gtest.h>

namespace sinew::test_inverse_ffd {

namespace {

using namespace lattices;

Pose unit_cube() { return shapes::affine(0.5 * Matrix3::Identity(), {0.5, 0.5, 0.5}); }

InverseFfdOptions chosen(int n, LatticeBasis basis = LatticeBasis::bspline, double cut_off = 1e-3)
{
    return {{n, n, n}, basis, std::min(3, n - 1), cut_off, unit_cube()};
}

SpaceTraits traits()
{
    const Points handles = in_box(6, {0.1, 0.1, 0.1}, {0.9, 0.9, 0.9}, 4);
    return {.name = "InverseFfd",
            .variants = {{"bspline", [=] { return std::make_shared<InverseFfd>(view(handles), chosen(5)); }},
                         {"bezier",
                          [=] {
                              return std::make_shared<InverseFfd>(view(handles),
                                                                  chosen(4, LatticeBasis::bezier));
                          }}},
            .control = handles,
            .points = in_box(400, {-0.2, -0.2, -0.2}, {1.2, 1.2, 1.2}),
            .translation = {},
            .follow = 12.0, // constraints near each other are met by larger moves between them
            .other = [=] { return std::make_shared<InverseFfd>(view(handles), chosen(4)); }};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(InverseFfd, SpaceContract, testing::Values(traits()));

TEST(InverseFfd, its_own_box_holds_the_points_and_the_handles)
{
    const Points handle = Points::Constant(1, 3, 3.0), flat = in_box(50, {0, 0, 1}, {2, 4, 1});
    InverseFfd method(view(handle));
    EXPECT_TRUE(method.bind(view(flat)).outside.empty());
    const Points rest = method.lattice();
    EXPECT_EQ(rest.rows(), 125);
    EXPECT_LT(rest.col(0).minCoeff(), 0.0);
    EXPECT_GT(rest.col(2).maxCoeff(), 3.0);
}

} // namespace sinew::test_inverse_ffd
