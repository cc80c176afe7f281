// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/mls.h"

#include "tests/native/methods/space/contract.h"
#include "tests/native/methods/space/handle_points/fixture.h"

#include <gtest/gtest.h>

namespace sinew::test_mls {

namespace {

using handles::moved, handles::posed, handles::random_points, handles::regions, handles::three_poses,
    handles::warped;

constexpr WeightPrecision doubles = WeightPrecision::double_precision;
constexpr MlsMaps every_kind[] = {MlsMaps::affine, MlsMaps::similarity, MlsMaps::rigid};

SpaceTraits traits(MlsMaps kind, const std::string& name)
{
    const Points centres = random_points(25, 1.0, 3);
    const HandlePoints handles{view(centres)};
    const std::vector<std::array<int, 2>> edges{{0, 1}, {2, 3}, {3, 4}};
    SpaceTraits traits{
        .name = name,
        .variants = {{"single", [=] { return std::make_shared<Mls>(handles, MlsOptions{kind}); }},
                     {"double",
                      [=] { return std::make_shared<Mls>(handles, MlsOptions{kind, 2.0, {}, doubles}); }},
                     {"segments",
                      [=] { return std::make_shared<Mls>(handles, MlsOptions{kind, 1.5, edges, doubles}); }}},
        .control = centres,
        .points = random_points(600, 1.3, 4),
        .follow = 8.0, // of affine maps, which may stretch
        .other = [=] { return std::make_shared<Mls>(handles, MlsOptions{kind, 3.0}); }};
    if (kind != MlsMaps::rigid)
        traits.similarity = 1e-11;
    if (kind == MlsMaps::affine)
        traits.affine = 1e-11;
    return traits;
}

} // namespace

INSTANTIATE_TEST_SUITE_P(Mls, SpaceContract,
                         testing::Values(traits(MlsMaps::affine, "affine"),
                                         traits(MlsMaps::similarity, "similarity"),
                                         traits(MlsMaps::rigid, "rigid")));

TEST(Mls, a_point_on_a_handle_gets_its_target_exactly)
{
    const HandlePoints handles = regions(40);
    const Points goals = moved(handles, three_poses);
    for (const MlsMaps kind : every_kind)
        for (const WeightPrecision precision : {doubles, WeightPrecision::single_precision}) {
            Mls mls(handles, {kind, 1.0, {}, precision});
            EXPECT_LT(shapes::distance(warped(mls, handles.points(), posed(handles, three_poses)), goals),
                      1e-14 * 8);
            // And what comes near gets near: the map is continuous.
            const Points near = handles.points().array() + 1e-7;
            EXPECT_LT(shapes::distance(warped(mls, near, posed(handles, three_poses)), goals), 1e-5);
        }
}

TEST(Mls, a_segment_takes_its_points_along)
{
    Points ends(5, 3);
    ends << 0, 0, 0, 1, 0, 0, 0, 1, 0.2, 1, 1, 0, 0.4, 0.3, 1;
    Points control = ends;
    control.row(1) << 0.8, 0.5, 0.1;
    control.row(4) << 0.4, 0.3, 1.4;
    Points on(9, 3), moved(9, 3);
    for (int k = 0; k < 9; ++k) {
        on.row(k) = ends.row(0) + k / 8.0 * (ends.row(1) - ends.row(0));
        moved.row(k) = control.row(0) + k / 8.0 * (control.row(1) - control.row(0));
    }
    for (const MlsMaps kind : every_kind) {
        Mls mls(HandlePoints(view(ends)), {kind, 1.0, {{0, 1}, {2, 3}}, doubles});
        EXPECT_LT(shapes::distance(warped(mls, on, control), moved), 1e-13);
        const Points near = on.array() + 1e-6;
        EXPECT_LT(shapes::distance(warped(mls, near, control), moved), 1e-3);
    }
}

TEST(Mls, flat_handles_are_fitted_by_rigid_maps_and_the_report_says_so)
{
    Points plane = random_points(12, 1.0, 5);
    plane.col(2).setZero();
    Mls mls(HandlePoints(view(plane)), {MlsMaps::affine, 1.0, {}, doubles});
    const Points points = random_points(40, 1.0, 6);
    EXPECT_EQ(mls.bind(view(points)).remarks.size(), 1U);
    EXPECT_EQ(mls.maps(), MlsMaps::rigid);
    const Pose turn = shapes::turn({1, 2, 3}, 80, {0, 0, 1}, {1, 0, 0});
    EXPECT_LT(shapes::distance(warped(mls, points, shapes::transformed(plane, turn)),
                               shapes::transformed(points, turn)),
              1e-12)
        << "a rigid map is carried by handles in a plane";
}

TEST(Mls, handles_on_a_line_turn_by_the_smallest_angle)
{
    Points line(3, 3);
    line << 0, 0, 0, 1, 0, 0, 2.5, 0, 0;
    const Points points = random_points(40, 1.0, 6);
    const Pose turn = shapes::turn({0, 0, 1}, 50, {0, 0, 0}, {1, 2, 3});
    for (const MlsMaps kind : {MlsMaps::rigid, MlsMaps::similarity}) {
        Mls mls(HandlePoints(view(line)), {kind, 1.0, {}, doubles});
        EXPECT_LT(shapes::distance(warped(mls, points, shapes::transformed(line, turn)),
                                   shapes::transformed(points, turn)),
                  1e-9);
    }
    Mls alone(HandlePoints(view(Points(line.topRows(1)))));
    EXPECT_LT(shapes::distance(warped(alone, points, Points(line.row(1))),
                               shapes::transformed(points, shapes::shift(1, 0, 0))),
              1e-15);
}

} // namespace sinew::test_mls
