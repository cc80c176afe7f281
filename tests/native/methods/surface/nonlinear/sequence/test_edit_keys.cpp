// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/sequence/edit_keys.h"

#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <limits>

namespace sinew::test_edit_keys {

namespace {

Pose turned(double degrees, const Vector3& axis = {0, 0, 1}, const Vector3& move = Vector3::Zero())
{
    return shapes::affine(shapes::rotation(axis, degrees), move);
}

double angle_about_z(const Pose& pose) { return std::atan2(pose(1, 0), pose(0, 0)) * 180 / shapes::pi; }

double gap(const Pose& a, const Pose& b) { return (a - b).cwiseAbs().maxCoeff(); }

/// The cubic through two values with two slopes, by its four equations.
double cubic(double from, double to, double a, double b, double slope_a, double slope_b, double at)
{
    Eigen::Matrix4d equations;
    for (int end = 0; end < 2; ++end) {
        const double x = end ? to : from;
        equations.row(2 * end) << 1, x, x * x, x * x * x;
        equations.row(2 * end + 1) << 0, 1, 2 * x, 3 * x * x;
    }
    const Eigen::Vector4d c = equations.fullPivLu().solve(Eigen::Vector4d(a, slope_a, b, slope_b));
    return c[0] + at * (c[1] + at * (c[2] + at * c[3]));
}

} // namespace

TEST(EditKeys, no_keys_edit_nothing)
{
    EXPECT_TRUE(EditKeys().empty());
    EXPECT_EQ(EditKeys().at(3, 7.5), shapes::still());
    const EditKeys keys({{10, 2, turned(30)}});
    EXPECT_EQ(keys.handle_count(), 3);
    for (int handle : {-1, 0, 1, 5})
        EXPECT_EQ(keys.at(handle, 10), shapes::still());
}

TEST(EditKeys, a_key_is_met_to_the_bit_and_held_before_the_first_and_after_the_last)
{
    shapes::Random random(3);
    std::vector<EditKey> all;
    for (double frame : {30.0, -4.0, 12.5, 80.0}) { // in any order
        Pose edit;
        edit << random.matrix(), random.vector();
        all.push_back({frame, 1, edit});
    }
    const EditKeys keys(all);
    for (const EditKey& key : all)
        EXPECT_EQ(keys.at(1, key.frame), key.edit);
    EXPECT_EQ(keys.at(1, -1e6), all[1].edit);
    EXPECT_EQ(keys.at(1, 1e6), all[3].edit);
    const EditKeys one({all[0]});
    for (double frame : {-9.0, 30.0, 31.0})
        EXPECT_EQ(one.at(1, frame), all[0].edit);
}

TEST(EditKeys, between_equal_keys_the_edit_is_constant_to_the_bit)
{
    const Pose held = turned(40, {1, 2, 3}, {1, 2, 3});
    const EditKeys keys({{0, 0, held},
                         {10, 0, held},
                         {20, 0, turned(90)},
                         {30, 0, shapes::still()},
                         {40, 0, shapes::still()}});
    for (double t : {.5, 3.0, 9.9}) {
        EXPECT_EQ(keys.at(0, t), held);
        EXPECT_EQ(keys.at(0, 30 + t), shapes::still());
    }
}

TEST(EditKeys, moves_are_the_cubics_of_the_definition)
{
    // One direction: the slope at the middle key is a b (a + b) / (a^2 + b^2).
    const double a = (3.0 - 1.0) / 10, b = (8.0 - 3.0) / 5, middle = a * b * (a + b) / (a * a + b * b);
    const EditKeys keys(
        {{0, 0, shapes::shift(1, 0, 0)}, {10, 0, shapes::shift(3, 0, 0)}, {15, 0, shapes::shift(8, 0, 0)}});
    for (double t = .25; t < 10; t += .5)
        EXPECT_NEAR(keys.at(0, t)(0, 3), cubic(0, 10, 1, 3, 0, middle, t), 1e-12);
    for (double t = 10.25; t < 15; t += .5)
        EXPECT_NEAR(keys.at(0, t)(0, 3), cubic(10, 15, 3, 8, middle, 0, t), 1e-12);
}

TEST(EditKeys, the_edit_is_smooth_and_never_exceeds_its_keys)
{
    shapes::Random random(8);
    std::vector<EditKey> all;
    for (int k = 0; k < 9; ++k) {
        Pose edit;
        edit << shapes::rotation(random.vector(), 80 * random.signed_unit()) *
                    Vector3(1.3, .7, 1 + .2 * random.signed_unit()).asDiagonal(),
            5 * random.vector();
        all.push_back({4.0 * k + random.signed_unit(), 0, edit});
    }
    const EditKeys keys(all);
    constexpr double h = 1e-5;
    for (int k = 1; k < 8; ++k) {
        const double t = all[k].frame;
        const Pose before = (keys.at(0, t) - keys.at(0, t - h)) / h,
                   after = (keys.at(0, t + h) - keys.at(0, t)) / h;
        EXPECT_LT(gap(before, after), 1e-3); // curvatures of some units times h, and rounding / h
    }
    // Along a line, between the two keys beside it.
    shapes::Random steps(5);
    std::vector<EditKey> line;
    for (int k = 0; k < 40; ++k)
        line.push_back({3.0 * k + steps.unit(), 0, shapes::shift(std::round(4 * steps.signed_unit()), 0, 0)});
    const EditKeys along(line);
    for (int k = 0; k + 1 < 40; ++k) {
        const double low = std::min(line[k].edit(0, 3), line[k + 1].edit(0, 3));
        const double high = std::max(line[k].edit(0, 3), line[k + 1].edit(0, 3));
        for (double s = 0; s <= 1; s += .05) {
            const double x = along.at(0, line[k].frame + s * (line[k + 1].frame - line[k].frame))(0, 3);
            EXPECT_GE(x, low - 1e-12);
            EXPECT_LE(x, high + 1e-12);
        }
    }
}

TEST(EditKeys, turns_add_up_over_several_keys)
{
    const EditKeys keys({{0, 0, turned(0)},
                         {10, 0, turned(120)},
                         {20, 0, turned(240)},
                         {30, 0, turned(360)},
                         {40, 0, turned(300)}});
    // Even steps: the slope at the middle keys is that of the line.
    EXPECT_NEAR(angle_about_z(keys.at(0, 15)), 180.0, 1e-9);
    EXPECT_NEAR(angle_about_z(keys.at(0, 14.9)), 178.8, 0.01);
    EXPECT_NEAR(angle_about_z(keys.at(0, 35)), -30.0, 1e-9); // back again, from 360 to 300
    double before = angle_about_z(keys.at(0, 20.0));
    for (double t = 20.5; t < 30; t += .5) { // goes on from 240 to 360 instead of back to 0
        const double now = angle_about_z(keys.at(0, t));
        EXPECT_GT(now, before) << t;
        EXPECT_LT(now, 0);
        before = now;
    }
    for (double t = 0; t <= 40; t += .25) {
        const Matrix3 R = keys.at(0, t).leftCols<3>();
        EXPECT_LT((R.transpose() * R - Matrix3::Identity()).norm(), 1e-14);
    }
}

TEST(EditKeys, does_not_depend_on_the_axes)
{
    shapes::Random random(2);
    const Matrix3 to = random.rotation();
    std::vector<EditKey> here, there;
    for (int k = 0; k < 5; ++k) {
        const Matrix3 A =
            shapes::rotation(random.vector(), 50) * (Matrix3::Identity() + .1 * random.matrix());
        const Vector3 m = random.vector();
        here.push_back({5.0 * k, 0, shapes::affine(A, m)});
        there.push_back({5.0 * k, 0, shapes::affine(to * A * to.transpose(), to * m)});
    }
    const EditKeys one(here), other(there);
    for (double t = .3; t < 20; t += .7) {
        const Pose pose = one.at(0, t);
        EXPECT_LT(
            gap(other.at(0, t), shapes::affine(to * pose.leftCols<3>() * to.transpose(), to * pose.col(3))),
            1e-12);
    }
}

TEST(EditKeys, a_mirrored_edit_stays_finite_between_its_keys)
{
    const EditKeys keys({{0, 0, shapes::still()},
                         {10, 0, shapes::affine(Vector3(1, 1, -1).asDiagonal())},
                         {20, 0, shapes::affine(Matrix3::Zero())}});
    for (double t = 0; t <= 20; t += .5)
        EXPECT_TRUE(keys.at(0, t).allFinite());
}

TEST(EditKeys, refuses_keys_that_mean_nothing_and_names_them)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto refused = [](const std::vector<EditKey>& keys, const std::string& words) {
        const auto make = [&] { EditKeys made(keys); };
        EXPECT_NE(std::string(refusal<InvalidOption>(make).what()).find(words), std::string::npos);
    };
    refused({{0, 0, turned(1)}, {nan, 0, turned(1)}}, "key 1 has a number that is not finite");
    refused({{0, 0, shapes::shift(nan, 0, 0)}}, "key 0 has a number that is not finite");
    refused({{0, -1, turned(1)}}, "key 0 names handle -1");
    refused({{7.5, 2, turned(1)}, {3, 2, turned(2)}, {7.5, 2, turned(3)}},
            "handle 2 has two keys at frame 7.5");
}

} // namespace sinew::test_edit_keys
