// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/handles/handle_control.h"

#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <limits>

namespace sinew::test_handle_control {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

HandlePoints held(const Points& points, std::vector<int> counts)
{
    return HandlePoints(view(points), std::move(counts));
}

/// Where a motion takes points.
Points moved(const HeldMotion& motion, const Points& points, const Vector3& centre, double unit)
{
    Points result = points;
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        result.row(i) += unit * motion((points.row(i).transpose() - centre) / unit).transpose();
    return result;
}

} // namespace

TEST(HandleControl, fits_the_motions_that_poses_are)
{
    shapes::Random random(4);
    const Vector3 centre(3, -1, 2);
    constexpr double unit = 5.0;
    const Pose pose = shapes::affine(random.matrix() + 2 * Matrix3::Identity(), {1, 2, 3}),
               rigid = shapes::turn({1, 2, 3}, 170, {0, 1, 0}, {1, 0, 2});
    const Points solid = random.dense(20, 3);
    Points plane = solid, line = solid, point = solid.topRows(1);
    plane.col(2).setZero();
    line.rightCols(2).setZero();
    for (const auto& [points, own] : std::vector<std::pair<Points, Pose>>{
             {solid, pose}, {solid, rigid}, {plane, rigid}, {line, rigid}, {point, rigid}}) {
        const HandleControl control(held(points, {static_cast<int>(points.rows())}), centre, unit);
        const Points posed = shapes::transformed(points, own);
        EXPECT_LT(shapes::distance(moved(control.motions(view(posed))[0], points, centre, unit), posed),
                  1e-12);
        EXPECT_LT(shapes::distance(moved(control.motions(Poses{own})[0], points, centre, unit), posed),
                  1e-12);
    }
    const HandleControl flat(held(plane, {20}), centre, unit);
    const HeldMotion found = flat.motions(view(shapes::transformed(plane, rigid)))[0];
    EXPECT_LT((found.turn + Matrix3::Identity() - rigid.leftCols<3>()).norm(), 1e-12)
        << "also across the plane";
}

TEST(HandleControl, moves_nothing_at_rest_to_the_last_bit)
{
    shapes::Random random(4);
    const Points points = random.dense(9, 3);
    const HandleControl control(held(points, {4, 4, 1}), {1, 2, 3}, 3.0);
    for (const auto& motions : {control.motions(view(points)), control.motions(Poses(3, shapes::still()))})
        for (const HeldMotion& motion : motions)
            EXPECT_TRUE(motion.turn.isZero(0.0) && motion.move.isZero(0.0));
}

TEST(HandleControl, refuses_by_name_and_takes_no_point_to_two_places)
{
    Points points = shapes::grid_points(3, 1); // 8 points
    points.row(6) = points.row(1); // of both handles
    const HandleControl control(held(points, {4, 4}), {0, 0, 0}, 1.0);
    const Pose still = shapes::still(), move = shapes::shift(1, 0, 0);
    EXPECT_NO_THROW(control.motions(Poses{move, move}));
    EXPECT_NO_THROW(control.motions(Poses{still, shapes::turn({0, 0, 1}, 30, points.row(1).transpose())}))
        << "which leaves the point";
    Points broken = points;
    broken(5, 1) = nan;
    Pose wrong = still;
    wrong(0, 0) = nan;
    const auto refused = [&](const auto& moved, const std::vector<int>& handles) {
        const auto call = [&] { control.motions(moved); };
        expect_elements(refusal<InvalidConstraint>(call), Error::Element::handle, handles);
    };
    refused(Poses{still, move}, {0, 1});
    refused(Poses{still, wrong}, {1});
    refused(view(broken), {1});
    EXPECT_THROW(control.motions(Poses{still}), InvalidConstraint);
    EXPECT_THROW(control.motions(view(broken.topRows(7).eval())), InvalidConstraint);
    const HandleControl soft(HandlePoints(view(points), {4, 4}, {1, 1, 1, 1, 1, 1, 0.5, 1}), {0, 0, 0}, 1.0);
    EXPECT_NO_THROW(soft.motions(Poses{still, move})) << "one gives way";
}

} // namespace sinew::test_handle_control
