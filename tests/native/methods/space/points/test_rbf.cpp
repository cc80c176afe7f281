// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/points/rbf.h"
#include "native/methods/space/points/rbf/near_centres.h"

#include "tests/native/methods/space/contract.h"
#include "tests/native/methods/space/handle_points/fixture.h"

#include <gtest/gtest.h>

#include <limits>

namespace sinew::test_rbf {

namespace {

using handles::moved, handles::posed, handles::random_points, handles::regions, handles::three_poses,
    handles::warped;

constexpr WeightPrecision doubles = WeightPrecision::double_precision;

/// {0, .5, 1}^3
Points cube_points()
{
    Points points(27, 3);
    for (int i = 0; i < 27; ++i)
        points.row(i) << 0.5 * (i / 9), 0.5 * (i / 3 % 3), 0.5 * (i % 3);
    return points;
}

SpaceTraits of_points()
{
    const Points centres = random_points(40, 1.0, 3);
    const auto variant = [&](const std::string& name, const RbfOptions& options) {
        return SpaceVariant{name,
                            [=] { return std::make_shared<Rbf>(HandlePoints(view(centres)), options); }};
    };
    return {
        .name = "points",
        .variants = {variant("triharmonic", {}), variant("biharmonic", {.function = RbfFunction::biharmonic}),
                     variant("wendland_c0", {.function = RbfFunction::wendland_c0}),
                     variant("wendland_c2", {.function = RbfFunction::wendland_c2}),
                     variant("wendland_c4", {.function = RbfFunction::wendland_c4, .radius = 1.5})},
        .control = centres,
        .points = random_points(600, 1.3, 4),
        // Rounding: weights of a sum of 40 functions are some hundred times the moves.
        .translation = 1e-10,
        .similarity = 1e-10,
        .affine = 1e-10,
        .follow = 6.0, // beyond the points, a cubic function grows
        .other = [=] { return std::make_shared<Rbf>(HandlePoints(view(centres)), RbfOptions{.degree = 1}); }};
}

SpaceTraits of_regions()
{
    const HandlePoints handles = regions(250);
    return {.name = "regions",
            .variants = {{"single", [=] { return std::make_shared<Rbf>(handles); }},
                         {"exact",
                          [=] {
                              return std::make_shared<Rbf>(
                                  handles, RbfOptions{.tolerance = 0.0, .precision = doubles});
                          }},
                         {"compact",
                          [=] {
                              return std::make_shared<Rbf>(
                                  handles, RbfOptions{.function = RbfFunction::wendland_c2, .radius = 0.3});
                          }}},
            .control = handles.control(),
            .points = random_points(400, 3.0, 4),
            .translation = 1e-6, // single precision
            .follow = 30.0,      // a step of one point of a frame is a shear
            .other = [=] { return std::make_shared<Rbf>(regions(59)); }};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(RbfPoints, SpaceContract, testing::Values(of_points()));
INSTANTIATE_TEST_SUITE_P(RbfRegions, SpaceContract, testing::Values(of_regions()));

TEST(Rbf, has_the_known_values_of_a_bump)
{
    Points points(3, 3);
    points << .25, .5, .5, .25, .25, .25, .5, .5, .5;
    Points moved = cube_points();
    moved(13, 2) += 1.0;
    Rbf rbf{HandlePoints(view(cube_points()))};
    const Points found = warped(rbf, points, moved) - points;
    EXPECT_NEAR(found(0, 2), 0.5833126, 5e-8); // the digits given
    EXPECT_NEAR(found(1, 2), 0.2463043, 5e-8);
    EXPECT_NEAR(found(2, 2), 1.0, 1e-13);
    EXPECT_EQ(found.leftCols(2).cwiseAbs().maxCoeff(), 0.0);
}

TEST(Rbf, an_incremental_fit_is_within_its_bound)
{
    const HandlePoints handles = regions(900);
    const Points control = posed(handles, three_poses);
    const double longest = (control - handles.control()).rowwise().norm().maxCoeff();
    const Points goals = moved(handles, three_poses);
    Eigen::Index last = 0;
    for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
        Rbf rbf(handles, {.tolerance = tolerance, .precision = doubles});
        const Points found = warped(rbf, handles.points(), control);
        EXPECT_LE(rbf.error(), tolerance * 1.001);
        EXPECT_LE(shapes::distance(found, goals), rbf.error() * longest);
        EXPECT_LT(rbf.centres().rows(), 1700) << "of 1801";
        EXPECT_GT(rbf.centres().rows(), last) << "more centres for a smaller error";
        last = rbf.centres().rows();
    }
}

TEST(Rbf, flat_handles_lose_the_maps_that_they_do_not_carry_and_the_report_says_so)
{
    const Points cube = random_points(60, 1.0, 21);
    Points plane = cube, line = cube, sphere = cube;
    plane.col(2).setConstant(0.3);
    line.rightCols(2).setConstant(-0.2);
    line.col(0).setLinSpaced(-1.0, 1.0);
    sphere.rowwise().normalize();
    struct Case
    {
        Points points;
        std::string says;
    };
    for (const auto& [points, says] :
         {Case{cube, ""}, Case{plane, "in a plane"}, Case{line, "on a line"}, Case{sphere, "quadratic maps"},
          Case{Points(cube.topRows(1)), "at one place"}, Case{Points(cube.topRows(2)), "on a line"}}) {
        for (const RbfFunction function :
             {RbfFunction::triharmonic, RbfFunction::biharmonic, RbfFunction::wendland_c2}) {
            if (says == "quadratic maps" && function != RbfFunction::triharmonic)
                continue;
            Rbf rbf(HandlePoints(view(points)), {.function = function});
            const SpaceReport report = rbf.bind(view(cube));
            EXPECT_EQ(report.remarks.empty(), says.empty());
            if (!says.empty() && !report.remarks.empty()) {
                EXPECT_NE(report.remarks.front().find(says), std::string::npos) << report.remarks.front();
            }
            // The handle points themselves follow, and translations are kept.
            const Points moves = random_points(static_cast<int>(points.rows()), 1.0, 22);
            EXPECT_LT(shapes::distance(warped(rbf, points, points + moves), points + moves), 1e-8) << says;
            const Points shifted = points.rowwise() + Eigen::RowVector3d(1, 2, 3);
            EXPECT_LT(shapes::distance(warped(rbf, cube, shifted),
                                       Points(cube.rowwise() + Eigen::RowVector3d(1, 2, 3))),
                      1e-9);
        }
    }
}

TEST(Rbf, every_kernel_and_degree_takes_handles_of_any_shape)
{
    const Points cube = random_points(60, 1.0, 51), moves = random_points(60, 0.2, 52);
    std::vector<Points> shapes_of_handles(7, cube);
    shapes_of_handles[1].col(0).setConstant(0.3);                   // a plane
    shapes_of_handles[2].rightCols(2).setConstant(-0.2);            // a line
    shapes_of_handles[2].col(0).setLinSpaced(-1.0, 1.0);
    shapes_of_handles[3].rowwise().normalize();                     // a sphere
    shapes_of_handles[4].bottomRows(30) = cube.topRows(30);         // each place twice
    shapes_of_handles[5] = Points::Constant(60, 3, 0.7);            // one place
    shapes_of_handles[6].col(2) = 1e-7 * cube.col(2);               // almost a plane
    const Points around = random_points(101, 3.0, 53);
    for (int function = 0; function < rbf_function_count; ++function)
        for (int degree = -1; degree <= 2; ++degree)
            for (std::size_t k = 0; k < shapes_of_handles.size(); ++k)
                for (const bool apart : {true, false}) {
                    const Points& points = shapes_of_handles[k];
                    Points moved = points + moves;
                    if (k == 4)
                        moved.bottomRows(30) = moved.topRows(30);
                    if (k == 5)
                        moved.rowwise() = Eigen::RowVector3d(moved.row(0));
                    const HandlePoints handles(view(points),
                                               apart ? std::vector<int>{} : std::vector<int>{30, 30});
                    Rbf rbf(handles, {.function = static_cast<RbfFunction>(function),
                                      .degree = degree,
                                      .radius = 0.4,
                                      .precision = doubles});
                    Points control = handles.control();
                    if (apart)
                        control = moved;
                    else
                        control.rowwise() += Eigen::RowVector3d(moves.row(0));
                    const Points expected =
                        apart ? moved : Points(points.rowwise() + Eigen::RowVector3d(moves.row(0)));
                    const auto what = [&] {
                        return ::testing::Message() << "function " << function << ", degree " << degree
                                                    << ", shape " << k << ", apart " << apart;
                    };
                    EXPECT_TRUE(warped(rbf, around, control).allFinite()) << what();
                    // Rounding of weights that are up to 1e8 times the moves, for the smoothest functions.
                    EXPECT_LT(shapes::distance(warped(rbf, points, control), expected), 1e-6) << what();
                }
}

TEST(Rbf, points_anywhere_stay_finite)
{
    Points points(4, 3);
    points << 1e200, 0, 0, -1e300, 1e300, 0, 0, 0, 1e308, 0.5, 0.5, 0.5;
    const Points centres = cube_points();
    Points moved = centres;
    moved(13, 2) += 1.0;
    for (int function = 0; function < rbf_function_count; ++function)
        for (const double radius : {1e-9, 0.5, 1e9}) {
            Rbf rbf(HandlePoints(view(centres)),
                    {.function = static_cast<RbfFunction>(function), .radius = radius});
            const Points found = warped(rbf, points, moved);
            EXPECT_TRUE(found.allFinite()) << function << " " << radius;
            if (radius < 1.0) { // else all centres are nearly one
                EXPECT_NEAR(found(3, 2), 1.5, 1e-12) << function << " " << radius;
            }
        }
}

TEST(NearCentres, runs_hold_all_that_are_within_reach_and_few_others)
{
    const Points centres = random_points(10000, 1.0, 41); // in a box of sides 2
    for (const double reach : {0.05, 0.1, 0.4, 5.0}) {
        const NearCentres near(centres, reach);
        std::int64_t visited = 0, needed = 0;
        shapes::Random random(42);
        for (int k = 0; k < 200; ++k) {
            const Vector3 low = 1.2 * random.vector(), high = low + 0.02 * random.vector().cwiseAbs();
            std::vector<char> seen(10000, 0);
            near.visit(low, high, [&](int begin, int end) {
                visited += end - begin;
                for (int j = begin; j < end; ++j)
                    ++seen[near.order()[j]];
            });
            const Eigen::AlignedBox3d box(low, high);
            for (int i = 0; i < 10000; ++i) {
                const bool is_near = box.exteriorDistance(Vector3(centres.row(i))) < reach;
                needed += is_near;
                ASSERT_LE(seen[i], 1);
                ASSERT_TRUE(seen[i] || !is_near);
            }
        }
        // The cells that a ball of two cells around meets have some three times its volume. There are four
        // cells for each centre, so that in the smallest ball a few more are met.
        EXPECT_LT(visited, 4 * needed + 200 * 4) << reach;
    }
    const NearCentres all(centres, std::numeric_limits<double>::infinity());
    int runs = 0;
    all.visit({9, 9, 9}, {9, 9, 9}, [&](int begin, int end) { runs += begin == 0 && end == 10000; });
    EXPECT_EQ(runs, 1);
    EXPECT_EQ(all.centres(), centres);
}

TEST(Rbf, points_that_nearly_coincide_are_met_in_the_mean)
{
    Points points = random_points(30, 1.0, 5);
    points.row(29) = points.row(0) + Eigen::RowVector3d(1e-9, 0, 0);
    Points moved = points;
    moved(0, 2) += 0.1;
    moved(29, 2) -= 0.1;
    Rbf rbf{HandlePoints(view(points))};
    const Points found = warped(rbf, points, moved);
    EXPECT_FALSE(rbf.bind(view(points)).remarks.empty());
    EXPECT_TRUE(found.allFinite());
    EXPECT_LT(shapes::distance(found.middleRows(1, 28), moved.middleRows(1, 28)), 1e-3);
    EXPECT_NEAR(found(0, 2), points(0, 2), 1e-3);
}

} // namespace sinew::test_rbf
