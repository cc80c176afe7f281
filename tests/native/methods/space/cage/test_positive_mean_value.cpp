// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/positive_mean_value.h"

#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

namespace sinew::test_positive_mean_value {

namespace {

using cages::doubles;
using cages::largest;

PositiveMeanValueOptions exact()
{
    PositiveMeanValueOptions options;
    options.weights = doubles;
    return options;
}

PositiveMeanValueOptions rays(int count)
{
    PositiveMeanValueOptions options = exact();
    options.exact = false;
    options.directions = count;
    return options;
}

RowMatrix weights(const SurfaceMesh& cage, const Points& points,
                  const PositiveMeanValueOptions& options = exact())
{
    return cages::weights<PositiveMeanValue>(cage, points, options);
}

void expect_barycentric(const RowMatrix& w, const SurfaceMesh& cage, const Points& points)
{
    cages::expect_barycentric(w, cage, points, 1e-9);
}

SpaceTraits traits()
{
    const SurfaceMesh u = cages::u_prism();
    return {.name = "PositiveMeanValue",
            .variants = {cages::variant<PositiveMeanValue>("exact", u, exact()),
                         cages::variant<PositiveMeanValue>("rays", u, rays(1024))},
            .control = u.points(),
            .points = cages::inside_u_prism(600, 1e-3),
            .affine = 2e-10,
            .outside = Vector3(1.5, 2, 0.5),
            .refuses_outside = true,
            .other = [u] { return std::make_shared<PositiveMeanValue>(Cage(u), rays(512)); }};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(PositiveMeanValue, SpaceContract, testing::Values(traits()));

TEST(PositiveMeanValue, equals_mean_values_in_convex_cages)
{
    const Points x = cages::in_ball(300, 0.5);
    for (const SurfaceMesh& cage : {shapes::octahedron(), shapes::sphere(2)})
        EXPECT_LT(largest(weights(cage, x) - cages::weights<MeanValue>(cage, x, doubles)), 1e-10);
    Points known(1, 3);
    known << .1, .2, .3;
    RowMatrix expected(1, 6);
    expected << .18652452, .08652452, .26392439, .06392439, .34955109, .04955109;
    EXPECT_LT(largest(weights(shapes::octahedron(), known) - expected), 5e-9); // the digits given
}

TEST(PositiveMeanValue, is_positive_where_mean_values_are_not)
{
    Points x(1, 3);
    x << .5, 2.5, .5;
    const SurfaceMesh u = cages::u_prism();
    EXPECT_LT(cages::weights<MeanValue>(u, x, doubles).minCoeff(), -0.006);
    const RowMatrix w = weights(u, x);
    expect_barycentric(w, u, x);
    for (int v : {2, 3, 10, 11}) // the top of the other arm is out of sight
        EXPECT_LT(w(0, v), 1e-15);
}

TEST(PositiveMeanValue, is_barycentric_close_to_the_cage)
{
    const SurfaceMesh u = cages::u_prism();
    for (double depth : {0.05, 1e-5}) {
        const Points x = cages::inside_u_prism(300, depth);
        expect_barycentric(weights(u, x), u, x);
    }
    Points close(4, 3); // to a face, an edge, a corner and the edge that both arms meet at
    close << 1e-9, 1.4, .3, 1e-9, 1.5, 1e-9, 1e-9, 1e-9, 1e-9, 1 - 1e-9, 1 - 1e-9, .4;
    expect_barycentric(weights(u, close), u, close);
}

TEST(PositiveMeanValue, is_linear_on_the_faces)
{
    const SurfaceMesh u = cages::u_prism();
    EXPECT_LT(largest(weights(u, u.points()) - RowMatrix::Identity(16, 16)), 1e-9);
    const SurfaceMesh octahedron = shapes::octahedron();
    Points x(2, 3);
    x << .2, .3, .5, 0, .4, .6;
    RowMatrix expected(2, 6);
    expected << .2, 0, .3, 0, .5, 0, 0, 0, .4, 0, .6, 0;
    EXPECT_LT(largest(weights(octahedron, x) - expected), 1e-9);
}

TEST(PositiveMeanValue, moves_on_without_jumps_as_parts_come_into_view)
{
    const SurfaceMesh u = cages::u_prism();
    constexpr int steps = 2000;
    Points path(steps + 1, 3);
    for (int i = 0; i <= steps; ++i)
        path.row(i) << .5 + .45 * i / steps, 2.8 - 2.3 * i / steps, .5 + .02 * i / steps;
    const RowMatrix w = weights(u, path), seen = weights(u, path, rays(1024));
    const double step = (w.bottomRows(steps) - w.topRows(steps)).cwiseAbs().maxCoeff();
    const double jump = (seen.bottomRows(steps) - seen.topRows(steps)).cwiseAbs().maxCoeff();
    EXPECT_LT(step, 2e-3);
    EXPECT_GT(jump, step); // what the preview is worse in
}

TEST(PositiveMeanValue, preview_errs_less_with_more_rays)
{
    const Points x = cages::inside_u_prism(50, 0.1);
    const SurfaceMesh u = cages::u_prism();
    const RowMatrix w = weights(u, x);
    const RowMatrix few = weights(u, x, rays(1024)), many = weights(u, x, rays(16384));
    expect_barycentric(many, u, x);
    EXPECT_LT(largest(few - w), 5e-3);
    EXPECT_LT(largest(many - w), largest(few - w) / 3);
}

TEST(PositiveMeanValue, names_points_outside_or_falls_back_on_mean_values)
{
    Points x(3, 3);
    x << .5, .5, .5, 1.5, 2, .5, 9, 9, 9;
    cages::expect_outside<PositiveMeanValue>(cages::u_prism(), exact(), x, {1, 2});
}

TEST(PositiveMeanValue, sees_one_part_of_a_cage_at_a_time)
{
    const SurfaceMesh two = shapes::joined(shapes::cube(), shapes::octahedron(), {5, 0, 0});
    const Points x = Points::Constant(1, 3, .4);
    const RowMatrix w = weights(two, x);
    expect_barycentric(w, two, x);
    EXPECT_LT(largest(w.rightCols(6)), 1e-15);
}

TEST(PositiveMeanValue, takes_faces_without_area)
{
    Points points = shapes::cube().points();
    points.row(6) = points.row(5);
    const SurfaceMesh flat = shapes::moved(shapes::cube(), points);
    const Points x = Points::Constant(1, 3, .25);
    expect_barycentric(weights(flat, x), flat, x);
}

} // namespace sinew::test_positive_mean_value
