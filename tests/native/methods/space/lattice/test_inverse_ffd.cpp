// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/lattice/inverse_ffd.h"

#include "tests/native/methods/space/contract.h"
#include "tests/native/methods/space/lattice/lattices.h"
#include "tests/native/refusals.h"

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

TEST(InverseFfd, dragging_the_middle_of_a_quadratic_lattice)
{
    const Points middle = Points::Constant(1, 3, 0.5);
    for (const LatticeBasis basis : {LatticeBasis::bezier, LatticeBasis::bspline}) {
        InverseFfd method(view(middle), chosen(3, basis));
        method.bind(view(middle));
        Points dragged = middle;
        dragged(0, 1) += 0.5;
        const Points moves = method.control_moves(view(dragged));
        EXPECT_NEAR(moves(13, 1) / 0.5, 64.0 / 27.0, 1e-12); // 2.370370
        EXPECT_NEAR(moves(0, 1) / 0.5, 8.0 / 27.0, 1e-12);
        EXPECT_EQ(moves.col(0).cwiseAbs().maxCoeff(), 0.0);
        EXPECT_NEAR(warped(method, dragged)(0, 1), 1.0, 1e-14);
    }
}

TEST(InverseFfd, constraints_that_can_be_met_are_and_what_is_far_stays)
{
    const Points handles = in_box(4, {0.1, 0.1, 0.1}, {0.3, 0.3, 0.3}, 5);
    Points points(5, 3);
    points.topRows(4) = handles;
    points.row(4) << 0.99, 0.99, 0.99;
    InverseFfdOptions fine = chosen(9);
    fine.cut_off = 1e-6; // four constraints in one cell have small singular values, and can still be met
    InverseFfd method(view(handles), fine);
    method.bind(view(points));
    Points dragged = handles;
    dragged.row(2) += Eigen::RowVector3d(0.2, 0, -0.1);
    const Points found = warped(method, dragged);
    EXPECT_LT(shapes::distance(found.topRows(4), dragged), 1e-7);
    EXPECT_EQ(found.row(4), points.row(4));
}

TEST(InverseFfd, a_constraint_that_is_met_already_changes_nothing)
{
    // The least solution of one drag also is the least one that keeps a further place where it has gone.
    const Points one = Points::Constant(1, 3, 0.4), points = in_box(30, {0, 0, 0}, {1, 1, 1});
    InverseFfd first(view(one), chosen(5));
    first.bind(view(points));
    const Points dragged = one.array() + 0.2, shape = warped(first, dragged);
    Points two(2, 3), posed(2, 3);
    two << one, points.row(3);
    posed << dragged, shape.row(3);
    InverseFfd second(view(two), chosen(5));
    second.bind(view(points));
    EXPECT_LT(shapes::distance(warped(second, posed), shape), 1e-12);
}

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

TEST(InverseFfd, refusals)
{
    const Points none(0, 3), one = Points::Constant(1, 3, 0.5);
    EXPECT_THROW(InverseFfd(view(none), {}), InvalidConstraint);
    Points bad = one;
    bad(0, 0) = std::numeric_limits<double>::infinity();
    expect_elements(refusal<InvalidConstraint>([&] { InverseFfd(view(bad), {}); }), Error::Element::vertex,
                    {0});
    const auto refuse = [&](auto change) {
        InverseFfdOptions wrong;
        change(wrong);
        EXPECT_THROW(InverseFfd(view(one), wrong), InvalidOption);
    };
    refuse([](InverseFfdOptions& options) { options.resolution[0] = 1; });
    refuse([](InverseFfdOptions& options) { options.resolution[1] = 17; });
    refuse([](InverseFfdOptions& options) { options.degree = 0; });
    refuse([](InverseFfdOptions& options) { options.cut_off = 0.0; });
    EXPECT_THROW(InverseFfd(view(one), {}).control_moves(view(one)), InvalidConstraint);
}

} // namespace sinew::test_inverse_ffd
