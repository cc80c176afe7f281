// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/positive_mean_value.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/space/cage/mean_value.h"
#include "tests/native/space/cage/cages.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew {

namespace {

constexpr PointWeightOptions doubles{WeightPrecision::double_precision, 0.0};

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
    PositiveMeanValue coordinates(Cage(cage), options);
    coordinates.bind(view(points));
    return coordinates.weights().dense();
}

double largest(const RowMatrix& matrix) { return matrix.cwiseAbs().maxCoeff(); }

void expect_barycentric(const RowMatrix& w, const SurfaceMesh& cage, const Points& points)
{
    EXPECT_LT((w.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
    EXPECT_LT(largest(w * cage.points() - points), 1e-9 * shapes::size(cage.points()));
    EXPECT_GE(w.minCoeff(), 0);
}

/// By rays whose first faces are found one by one, and hat functions solved for: shares no code with ours.
Eigen::RowVectorXd by_rays(const SurfaceMesh& cage, const Vector3& x, int count)
{
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(cage.vertex_count());
    for (int k = 0; k < count; ++k) {
        const double z = 1 - (2 * k + 1) / static_cast<double>(count);
        const double turn = 2.399963229728653 * k; // the golden angle
        const double r = std::sqrt(1 - z * z);
        const Vector3 d(r * std::cos(turn), r * std::sin(turn), z);
        double nearest = 1e300;
        Eigen::RowVectorXd hit = Eigen::RowVectorXd::Zero(cage.vertex_count());
        for (const Triangle& t : cage.triangles()) {
            // x + s d = a + u (b - a) + v (c - a)
            Matrix3 system;
            system << d, cage.point(t[0]) - cage.point(t[1]), cage.point(t[0]) - cage.point(t[2]);
            const Vector3 suv = system.partialPivLu().solve(cage.point(t[0]) - x);
            if (!suv.allFinite() || suv[0] <= 0 || suv[0] >= nearest || suv[1] < 0 || suv[2] < 0 ||
                suv[1] + suv[2] > 1)
                continue;
            nearest = suv[0];
            hit.setZero();
            hit[t[0]] = 1 - suv[1] - suv[2];
            hit[t[1]] = suv[1];
            hit[t[2]] = suv[2];
        }
        sum += hit / nearest;
    }
    return sum / sum.sum();
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
    for (const SurfaceMesh& cage : {shapes::octahedron(), shapes::sphere(2)}) {
        MeanValue plain(Cage(cage), doubles);
        plain.bind(view(x));
        EXPECT_LT(largest(weights(cage, x) - plain.weights().dense()), 1e-10);
    }
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
    MeanValue plain(Cage(u), doubles);
    plain.bind(view(x));
    EXPECT_LT(plain.weights().dense().minCoeff(), -0.006);
    const RowMatrix w = weights(u, x);
    expect_barycentric(w, u, x);
    for (int v : {2, 3, 10, 11}) // the top of the other arm is out of sight
        EXPECT_LT(w(0, v), 1e-15);
}

TEST(PositiveMeanValue, agrees_with_rays_in_concave_cages)
{
    Points x(3, 3);
    x << .5, 2.5, .5, 1.5, .5, .5, .2, .3, .7;
    const RowMatrix u = weights(cages::u_prism(), x);
    const SurfaceMesh bumpy = cages::bumpy(1, 0.3, 4);
    const Points y = cages::in_ball(3, 0.15);
    const RowMatrix b = weights(bumpy, y);
    for (int i = 0; i < 3; ++i) {
        // 20000 rays have a spacing of .025; what an edge cuts wrongly is its square times the edges in
        // sight.
        EXPECT_LT((u.row(i) - by_rays(cages::u_prism(), x.row(i).transpose(), 20000)).cwiseAbs().maxCoeff(),
                  3e-4);
        EXPECT_LT((b.row(i) - by_rays(bumpy, y.row(i).transpose(), 20000)).cwiseAbs().maxCoeff(), 3e-4);
    }
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
    PositiveMeanValue coordinates(Cage(cages::u_prism()), exact());
    try {
        coordinates.bind(view(x));
        FAIL();
    } catch (const InvalidConstraint& error) {
        EXPECT_EQ(error.elements(), (std::vector<int>{1, 2}));
    }
    PositiveMeanValueOptions options = exact();
    options.outside = CageOutside::mean_value;
    PositiveMeanValue both(Cage(cages::u_prism()), options);
    EXPECT_EQ(both.bind(view(x)).outside, (std::vector<int>{1, 2}));
    MeanValue plain(Cage(cages::u_prism()), doubles);
    plain.bind(view(x));
    EXPECT_LT((both.weights().dense() - plain.weights().dense()).bottomRows(2).norm(), 1e-12);
}

TEST(PositiveMeanValue, sees_one_part_of_a_cage_at_a_time)
{
    const SurfaceMesh two = shapes::joined(shapes::cube(), shapes::octahedron(), {5, 0, 0});
    const Points x = Points::Constant(1, 3, .4);
    const RowMatrix w = weights(two, x);
    expect_barycentric(w, two, x);
    EXPECT_LT(largest(w.rightCols(6)), 1e-15);
}

TEST(PositiveMeanValue, refuses_odd_and_too_few_directions)
{
    EXPECT_THROW(PositiveMeanValue(Cage(shapes::cube()), rays(9)), InvalidOption);
    EXPECT_THROW(PositiveMeanValue(Cage(shapes::cube()), rays(0)), InvalidOption);
    EXPECT_THROW(PositiveMeanValue(Cage(shapes::cube()), rays(-1024)), InvalidOption);
}

TEST(PositiveMeanValue, takes_faces_without_area)
{
    Points points = shapes::cube().points();
    points.row(6) = points.row(5);
    const SurfaceMesh flat = shapes::moved(shapes::cube(), points);
    const Points x = Points::Constant(1, 3, .25);
    expect_barycentric(weights(flat, x), flat, x);
}

} // namespace sinew
