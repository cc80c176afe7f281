// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/points/rbf.h"
#include "native/methods/space/points/rbf/near_centres.h"

#include "tests/native/methods/space/contract.h"
#include "tests/native/methods/space/handle_points/fixture.h"

#include <gtest/gtest.h>

#include <limits>

namespace sinew::test_rbf {

namespace {

using handles::random_points, handles::regions;

constexpr WeightPrecision doubles = WeightPrecision::double_precision;

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

// What it does to points is in tests/bindings/oracles/test_oracles_points.py.
INSTANTIATE_TEST_SUITE_P(RbfPoints, SpaceContract, testing::Values(of_points()));
INSTANTIATE_TEST_SUITE_P(RbfRegions, SpaceContract, testing::Values(of_regions()));

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

} // namespace sinew::test_rbf
