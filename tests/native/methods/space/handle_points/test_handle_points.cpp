// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/handle_points/handle_points.h"

#include "tests/native/methods/space/handle_points/fixture.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sinew::test_handle_points {

namespace {

using handles::posed;

/// A region, a point, and a region that holds the place of the point.
Points places()
{
    Points points(8, 3);
    points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 5, 5, 2, 0, 0, 3, 0, 1, 2, 2, 2, 5, 5, 5;
    return points;
}

} // namespace

TEST(HandlePoints, has_one_control_point_for_one_point_and_four_for_more)
{
    const HandlePoints handles(view(places()), {3, 1, 4});
    EXPECT_EQ(handles.handle_count(), 3);
    EXPECT_EQ(handles.control().rows(), 9);
    EXPECT_EQ(handles.control().row(4), places().row(3));
    EXPECT_EQ(handles.handle_of(3), 1);
    EXPECT_FALSE(handles.all_single());
    EXPECT_TRUE(HandlePoints(view(places())).all_single());
    EXPECT_NEAR(handles.size(), 5 * std::sqrt(3.0), 1e-14) << "from (0, 0, 0) to (5, 5, 5)";
}

TEST(HandlePoints, shares_give_the_places_of_the_points_at_every_pose)
{
    const HandlePoints handles(view(places()), {3, 1, 4});
    const RowMatrix shares = handles.all_shares();
    EXPECT_LT((shares.rowwise().sum().array() - 1.0).abs().maxCoeff(), 1e-15);
    Matrix3 shear;
    shear << 1.2, 0.3, 0, -0.4, 0.8, 0.1, 0.5, 0.2, 2;
    const std::vector<Pose> poses{shapes::affine(shear, {1, 2, 3}), shapes::shift(1, 0, 0),
                                  shapes::turn({1, 2, 3}, 50)};
    const Points control = posed(handles, poses), found = shares * control;
    for (int i = 0; i < handles.point_count(); ++i) {
        const Vector3 expected = apply(poses[handles.handle_of(i)], Vector3(places().row(i).transpose()));
        EXPECT_LT((found.row(i).transpose() - expected).norm(), 1e-14 * 10) << i;
    }
    for (const int h : {0, 2})
        EXPECT_LT((handles.map(view(control), h) - poses[h]).norm(), 1e-14 * 10);
    EXPECT_EQ(handles.map(view(control), 1), shapes::shift(1, 0, 0));
    EXPECT_EQ(handles.map(view(handles.control()), 0), shapes::still()) << "at rest, to the last bit";
}

TEST(HandlePoints, refuses_poses_that_pull_one_place_apart_and_names_the_handles)
{
    const HandlePoints handles(view(places()), {3, 1, 4});
    const auto check = [&](const std::vector<Pose>& poses) {
        const Points control = posed(handles, poses);
        handles.check(view(control));
    };
    const Pose move = shapes::shift(0, 0, 1), still = shapes::still();
    EXPECT_NO_THROW(check({move, still, still}));
    EXPECT_NO_THROW(check({still, move, move}));
    expect_elements(refusal<InvalidConstraint>([&] { check({still, move, still}); }), Error::Element::handle,
                    {1, 2});
    expect_elements(refusal<InvalidConstraint>([&] {
                        check({still, shapes::shift(std::numeric_limits<double>::quiet_NaN(), 0, 0), still});
                    }),
                    Error::Element::handle, {1});
    EXPECT_THROW(handles.check(view(places())), InvalidConstraint) << "another number of points";
}

TEST(HandlePoints, refuses_no_points_empty_handles_numbers_that_are_not_finite_and_weights_that_are_no_shares)
{
    const auto made = [](const Points& points, const std::vector<int>& counts,
                         const std::vector<double>& weights = {}) {
        return HandlePoints(view(points), counts, weights);
    };
    EXPECT_THROW(made(Points(0, 3), {}), InvalidConstraint);
    EXPECT_THROW(made(places(), {3, 4}), InvalidConstraint);
    expect_elements(refusal<InvalidConstraint>([&] { made(places(), {3, 0, 5, 0}); }), Error::Element::handle,
                    {1, 3});
    Points broken = places();
    broken(6, 0) = std::numeric_limits<double>::infinity();
    expect_elements(refusal<InvalidConstraint>([&] { made(broken, {3, 1, 4}); }), Error::Element::handle,
                    {2});
    EXPECT_THROW(made(places(), {3, 1, 4}, std::vector<double>(7, 1.0)), InvalidConstraint);
    for (const double weight : {0.0, -1.0, 1.5, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_THROW(made(places(), {3, 1, 4}, std::vector<double>(8, weight)), InvalidOption);
    const HandlePoints hard = made(places(), {3, 1, 4}),
                       soft = made(places(), {3, 1, 4}, {1, 1, 1, 1, 1, 1, 1, 0.5});
    EXPECT_EQ(hard.twins().size(), 1) << "the place of points 3 and 7";
    EXPECT_TRUE(soft.twins().empty());
    EXPECT_EQ(hard.weight(7), 1.0);
    EXPECT_EQ(soft.weight(7), 0.5);
    EXPECT_FALSE(soft == hard);
}

} // namespace sinew::test_handle_points
