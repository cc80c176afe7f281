// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/attachments.h"

#include "native/operators/fits/rotation_fit.h"
#include "tests/native/allocations.h"
#include "tests/native/attachments/scenes.h"
#include "tests/native/refusals.h"

namespace sinew::test_attachments {

using scenes::Carried;
using scenes::Scene;

/// The rotation that takes one shape to the other, as closely as one does.
Matrix3 turn_between(const Points& before, const Points& after)
{
    const Eigen::RowVector3d from = before.colwise().mean(), to = after.colwise().mean();
    return fit_rotation((after.rowwise() - to).transpose() * (before.rowwise() - from));
}

/// How far one shape is from the other, moved rigidly as closely as can be.
double off_rigid(const Points& before, const Points& after)
{
    const Eigen::RowVector3d from = before.colwise().mean(), to = after.colwise().mean();
    return shapes::distance(after.rowwise() - to,
                            (before.rowwise() - from) * turn_between(before, after).transpose());
}

/// The largest change of an edge's length, as a share of it.
double worst_stretch(const Carried& carried, int part, const Points& moved)
{
    double worst = 0.0;
    for (const auto& [a, b] : carried.mesh.edges())
        if (a >= carried.scene.firsts[part] && a < carried.scene.firsts[part + 1]) {
            const double before = (carried.mesh.point(a) - carried.mesh.point(b)).norm();
            worst = std::max(worst, std::abs((moved.row(a) - moved.row(b)).norm() / before - 1));
        }
    return worst;
}

const std::vector<Pose> similarities{
    shapes::still(),
    shapes::turn({1, 2, 3}, 115, {0, 0, 0}, {30, -20, 50}),
    shapes::turn({0, 1, 0}, 180, {0, 0, 0}, {1, 1, 1}),
    shapes::affine(1.7 * shapes::rotation({1, 2, 3}, 115), {5, 5, 5}),
    shapes::affine(.3 * shapes::rotation({3, 2, 1}, -57)),
    shapes::affine(1e-3 * Matrix3::Identity()),
};

TEST(Attachments, similarities_of_the_body_or_of_an_incoming_pose_are_those_of_all_parts)
{
    for (const auto& [name, scene] : scenes::all()) {
        SCOPED_TRACE(name);
        const Carried carried(scene);
        const Points& rest = carried.mesh.points();
        const Points incoming = carried.deformed([](const Vector3& p) { return scenes::rolled(p, 9); });
        for (const Pose& pose : similarities) {
            const Points all = shapes::transformed(rest, pose), other = shapes::transformed(incoming, pose);
            EXPECT_LT(shapes::distance(carried.moved(all), all), 1e-12 * shapes::size(rest));
            EXPECT_LT(shapes::distance(carried.moved(other, view(incoming)), other),
                      1e-12 * shapes::size(incoming));
        }
        // The rest as the incoming shape is none, to the bit.
        const Points bent = carried.deformed(scenes::twisted);
        EXPECT_EQ(carried.moved(bent, view(carried.mesh.points())), carried.moved(bent));
    }
}

TEST(Attachments, what_the_riding_points_were_before_does_not_matter)
{
    for (const auto& [name, scene] : scenes::all()) {
        SCOPED_TRACE(name);
        const Carried carried(scene);
        const Points bent = carried.deformed(scenes::twisted), once = carried.moved(bent);
        Points twice = once;
        carried.attachments.move({}, twice);
        EXPECT_EQ(twice, once);
        const ThreadLimit alone(1);
        EXPECT_EQ(carried.moved(bent), once);
        EXPECT_EQ(Carried(scene).moved(bent), once) << "bound on one thread";
    }
}

TEST(Attachments, collapsed_mirrored_and_stretched_bodies_give_finite_parts_and_one_frame_keeps_its_size)
{
    for (const auto& [name, scene] : scenes::all()) {
        const Carried carried(scene);
        const Points moved = carried.moved(Points(carried.mesh.points() * Vector3(2, 1, 1).asDiagonal()));
        for (const Ride& ride : carried.attachments.rides())
            if (ride.frame_count == 1) {
                EXPECT_LT(worst_stretch(carried, ride.part, moved), 1e-12) << name << " " << ride.part;
            }
        for (const Vector3& scale :
             {Vector3(0, 0, 0), Vector3(-1, 1, 1), Vector3(1, 1, 0), Vector3(1, 0, 0)}) {
            const Points flat = carried.mesh.points() * scale.asDiagonal();
            EXPECT_TRUE(carried.moved(flat).allFinite()) << name;
            EXPECT_TRUE(carried.moved(carried.mesh.points(), view(flat)).allFinite()) << name;
        }
    }
}

TEST(Attachments, a_ball_in_a_bent_tube_keeps_its_shape_and_its_distance_to_the_wall)
{
    const Carried carried(scenes::tube_and_balls());
    for (double radius : {20.0, 10.0, 5.0}) {
        const Points moved = carried.moved([&](const Vector3& p) { return scenes::rolled(p, radius); });
        const Points after = carried.scene.piece(moved, 1);
        EXPECT_LT(off_rigid(carried.rest(1), after), 1e-6);
        double wall = 1; // the bent tube is a torus of this radius
        for (Eigen::Index v = 0; v < after.rows(); ++v) {
            const double across = std::hypot(after(v, 0) - 5, radius - after(v, 2)) - radius;
            wall = std::min(wall, 1 - std::hypot(across, after(v, 1)));
        }
        EXPECT_NEAR(wall, .4, .01 * .4) << radius;
        EXPECT_LT((after.colwise().mean() - Eigen::RowVector3d(5, 0, 0)).norm(), .03 / radius);
    }
}

TEST(Attachments, a_button_and_a_strap_follow_a_plate_that_is_rolled_up)
{
    const Carried carried({scenes::plate(81, 81), scenes::block({.4, .4, .1}, {3, 5, .2}, {4, 4, 1}),
                           scenes::block({8, .4, .1}, {5, 7.5, .2}, {80, 4, 1})});
    EXPECT_EQ(carried.ride(1).frame_count, 1);
    EXPECT_GT(carried.ride(2).frame_count, 4);
    for (double radius : {8.0, 4.0, 2.0}) {
        const auto by = [&](const Vector3& p) { return scenes::rolled(p, radius); };
        const Points exact = carried.deformed(by), moved = carried.moved(by);
        const Points button = carried.scene.piece(moved, 1);
        const Matrix3 R = turn_between(carried.rest(1), button);
        EXPECT_NEAR(std::atan2(-R(2, 0), R(0, 0)), 2 / radius, .01) << radius;
        EXPECT_LT((button.colwise().mean() - by({3, 5, .2}).transpose()).norm(), .05 / radius);
        const Points off = carried.scene.piece(moved, 2) - carried.scene.piece(exact, 2);
        EXPECT_LT(std::sqrt(off.rowwise().squaredNorm().mean()), .08 / radius) << radius;
    }
}

TEST(Attachments, a_belt_and_a_tooth_follow_a_twisted_tube)
{
    const Carried carried({scenes::tube(1, 10), scenes::ring(1.12, .1, 5),
                           scenes::block({.2, .2, .2}, {3, 0, 1.1}, {3, 3, 3})});
    const Points exact = carried.deformed(scenes::twisted), moved = carried.moved(scenes::twisted);
    EXPECT_LT((carried.scene.piece(moved, 1) - carried.scene.piece(exact, 1)).cwiseAbs().maxCoeff(), .04);
    const Matrix3 R = turn_between(carried.rest(2), carried.scene.piece(moved, 2));
    EXPECT_NEAR(std::atan2(R(2, 1), R(1, 1)), .9, .01);
}

TEST(Attachments, an_iris_rides_on_the_eye_and_all_of_it_is_one_rigid_body)
{
    const Carried carried(scenes::head());
    EXPECT_EQ(carried.ride(1).host, 0);
    EXPECT_EQ(carried.ride(2).host, 1);
    EXPECT_TRUE(carried.ride(3).host == 1 || carried.ride(3).host == 2);
    EXPECT_EQ(carried.ride(4).host, 0);
    EXPECT_EQ(carried.ride(5).host, 4);
    const Points moved = carried.moved(scenes::twisted);
    const int first = carried.scene.firsts[1], count = carried.scene.firsts[4] - first;
    EXPECT_LT(off_rigid(carried.mesh.points().middleRows(first, count), moved.middleRows(first, count)),
              1e-10);
}

TEST(Attachments, a_part_midway_between_two_limbs_follows_one_of_them_whole)
{
    const Carried carried(scenes::limbs());
    const Points moved = carried.moved(scenes::stride);
    for (int part : {1, 2}) {
        // Each limb moves rigidly there, so following both would show in the turn.
        const Matrix3 R = turn_between(carried.rest(part), carried.scene.piece(moved, part));
        EXPECT_NEAR(std::abs(std::atan2(R(2, 1), R(1, 1))), 50 * shapes::pi / 180, .01) << part;
        EXPECT_LT(worst_stretch(carried, part, moved), 1e-12);
    }
    EXPECT_LT(worst_stretch(carried, 3, moved), 4) << "the cloth over both is not torn";
}

TEST(Attachments, compact_parts_are_rigid_at_any_size_and_clothes_bend)
{
    EXPECT_EQ(Carried({scenes::tube(1, 10), scenes::ball(1.6, {5, -1.6, 0})}).ride(1).frame_count, 1);
    const scenes::Piece sleeve = scenes::sheet(30, 24, false, true, [](double a, double b) {
        const double angle = 2 * shapes::pi * b;
        return Vector3(3 + 4 * a, 1.1 * std::cos(angle), 1.1 * std::sin(angle));
    });
    EXPECT_GE(Carried({scenes::tube(1, 10), sleeve.inside_out()}).ride(1).frame_count, 4);
    scenes::Piece sock = scenes::tube(1, 10, 60, 24);
    for (Vector3& p : sock.points)
        p = p.cwiseProduct(Vector3(.42, 1.1, 1.1)) + Vector3(3, 0, 0);
    EXPECT_GE(Carried({scenes::tube(1, 10), sock}).ride(1).frame_count, 4);
    EXPECT_GE(Carried({scenes::tube(1, 10), sock.inside_out()}).ride(1).frame_count, 4);
}

TEST(Attachments, between_rigid_and_bending_there_is_no_jump)
{
    double before = 0.0;
    for (double length = .9; length < 2.05; length += .1) {
        const int cells = static_cast<int>(std::lround(length * 20));
        const Carried carried(
            {scenes::tube(1, 10), scenes::block({length, .2, .04}, {5, 0, 1.04}, {cells, 2, 1})});
        const Points moved =
            carried.scene.piece(carried.moved([](const Vector3& p) { return scenes::rolled(p, 7); }), 1);
        const double bent = off_rigid(carried.rest(1), moved) / length;
        EXPECT_LT(std::abs(bent - before), .03) << length;
        before = bent;
    }
    EXPECT_GT(before, .01) << "at last it bends";
}

TEST(Attachments, faces_without_area_and_loose_vertices_change_nothing_and_follow)
{
    Scene scene = scenes::belts();
    const Carried clean(scene);
    for (int v = 0; v + 1 < scene.body(); v += 7)
        scene.faces.push_back({v, v, v + 1});
    const int loose = scene.firsts.back();
    scene.add({{Vector3(4, 0, 1.2)}, {}});
    scene.add({{{6, 0, 1.2}, {6.1, 0, 1.2}, {6.2, 0, 1.2}}, {Triangle{0, 1, 2}}});
    const Carried carried(scene);
    const Points expected = clean.moved(scenes::twisted), moved = carried.moved(scenes::twisted);
    EXPECT_LT(shapes::distance(moved.topRows(loose), expected), 1e-3 * shapes::size(expected));
    const Points exact = carried.deformed(scenes::twisted);
    EXPECT_LT(shapes::distance(moved.bottomRows(4), exact.bottomRows(4)), .05);
}

TEST(Attachments, nothing_rides_without_the_option_or_without_a_surface)
{
    const SurfaceMesh mesh = scenes::head().mesh();
    const Components parts = connected_components(mesh);
    std::vector<bool> driven(parts.count, false);
    EXPECT_TRUE(Attachments(mesh, parts, driven, {.follow = true}).rides().empty());
    driven[0] = true;
    EXPECT_TRUE(Attachments(mesh, parts, driven, {}).rides().empty());
    Points positions = mesh.points();
    Attachments(mesh, parts, driven, {}).move({}, positions);
    EXPECT_EQ(positions, mesh.points());
    const SurfaceMesh flat = shapes::moved(mesh, Points::Zero(mesh.vertex_count(), 3));
    EXPECT_TRUE(Attachments(flat, parts, driven, {.follow = true}).rides().empty());
}

TEST(Attachments, a_frame_allocates_nothing)
{
    if (!allocations::counted())
        GTEST_SKIP() << "this build does not count";
    const Carried carried(scenes::belts());
    Points positions = carried.deformed(scenes::twisted);
    const Points incoming = carried.mesh.points();
    const ThreadLimit alone(1); // other threads make arrays of their own the first time
    for (const std::optional<PointsView>& entering :
         {std::optional<PointsView>(), std::optional<PointsView>(view(incoming))}) {
        carried.attachments.move(entering, positions);
        const allocations::Count count(1000);
        carried.attachments.move(entering, positions);
        EXPECT_EQ(count.so_far(), 0);
    }
}

} // namespace sinew::test_attachments
