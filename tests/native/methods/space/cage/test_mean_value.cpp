// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/mean_value.h"

#include "native/methods/space/cage/green.h"
#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

namespace sinew::test_mean_value {

namespace {

using cages::doubles;

RowMatrix weights_of(const SurfaceMesh& cage, const Points& points)
{
    return cages::weights<MeanValue>(cage, points, doubles);
}

double affine_error(const SurfaceMesh& cage, const Points& points)
{
    const RowMatrix W = weights_of(cage, points);
    const double sums = (W.rowwise().sum().array() - 1.0).abs().maxCoeff();
    return std::max(sums, shapes::distance(W * cage.points(), points));
}

SpaceTraits traits()
{
    const SurfaceMesh cage = shapes::u_prism();
    return {.name = "MeanValue",
            .variants = {cages::variant<MeanValue>("double", cage, doubles)},
            .control = cage.points(),
            .points = shapes::points_around(cage, 600, 1.3),
            .similarity = 1e-11,
            .affine = 1e-11,
            .other = [cage] { return std::make_shared<MeanValue>(Cage(cage)); }};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(MeanValue, SpaceContract, testing::Values(traits()));

TEST(MeanValue, reproduces_affine_maps_inside_and_outside)
{
    struct Case
    {
        SurfaceMesh cage;
        double reach, tolerance; // rounding of some hundred weights; outside they grow with the distance
    };
    for (const Case& at : {Case{shapes::octahedron(), 3.0, 1e-12}, Case{shapes::u_prism(), 2.0, 1e-11},
                           Case{shapes::bumpy_sphere(3), 1.5, 1e-11},
                           Case{shapes::joined(shapes::cube(), shapes::octahedron(), {4, 1, 0}), 1.5, 1e-11}})
        EXPECT_LT(affine_error(at.cage, shapes::points_around(at.cage, 200, at.reach)), at.tolerance);
}

TEST(MeanValue, is_piecewise_linear_on_the_cage)
{
    for (const SurfaceMesh& cage : {shapes::bumpy_sphere(1), shapes::u_prism()}) {
        const Triangle& t = cage.triangles()[3];
        const Vector3 shares(0.2, 0.3, 0.5);
        Points x(3, 3);
        x.row(0) = cage.points().row(t[0]);
        x.row(1) = 0.25 * cage.points().row(t[1]) + 0.75 * cage.points().row(t[2]);
        x.row(2) = shares[0] * cage.points().row(t[0]) + shares[1] * cage.points().row(t[1]) +
                   shares[2] * cage.points().row(t[2]);
        RowMatrix expected = RowMatrix::Zero(3, cage.vertex_count());
        expected(0, t[0]) = 1.0;
        expected(1, t[1]) = 0.25;
        expected(1, t[2]) = 0.75;
        for (int k = 0; k < 3; ++k)
            expected(2, t[k]) = shares[k];
        EXPECT_LT((weights_of(cage, x) - expected).cwiseAbs().maxCoeff(), 1e-14);
    }
}

TEST(MeanValue, has_one_gradient_on_both_sides_of_a_triangles_plane)
{
    // Mean value weights are smooth off the cage, also where the formula changes: in planes and on their
    // rims.
    const SurfaceMesh cage = shapes::u_prism(); // the notch: x from 1 to 2, y > 1
    constexpr double step = 1e-4;
    for (const double near : {0.0, 1e-9, 1e-3}) {
        Points line(7, 3);
        for (int k = 0; k < 7; ++k)
            line.row(k) << 1.5, 3.0 + near + (k - 3) * step, 0.4; // through the plane y = 3
        const RowMatrix W = weights_of(cage, line);
        const RowMatrix third =
            W.row(6) - 3 * W.row(4) + 3 * W.row(2) - W.row(0); // step 2, of a smooth function
        EXPECT_LT(third.cwiseAbs().maxCoeff(), 1e-9); // 8 step^3 w''', 100 at most
    }
}

TEST(MeanValue, tells_which_points_lie_outside)
{
    const SurfaceMesh cage = shapes::u_prism();
    const Points points = shapes::points_around(cage, 500, 1.3);
    MeanValue coordinates(Cage(cage), doubles);
    const SpaceReport report = coordinates.bind(view(points));
    std::vector<int> expected;
    for (int i = 0; i < 500; ++i) {
        if (!cages::in_u_prism(points.row(i), 0.0))
            expected.push_back(i);
    }
    EXPECT_EQ(report.outside, expected);
    EXPECT_EQ(Green(Cage(cage), {.weights = doubles}).bind(view(points)).outside, expected);
    EXPECT_GT(expected.size(), 100u);
}

TEST(MeanValue, stays_finite_far_away)
{
    Points points(4, 3);
    points << 1e2, 3, 5, 1e5, 0, 0, 1e100, -1e100, 3, 0, 0, -1e300;
    const SurfaceMesh cage = shapes::bumpy_sphere(1);
    const RowMatrix W = weights_of(cage, points);
    EXPECT_TRUE(W.allFinite());
    EXPECT_LT((W.rowwise().sum().array() - 1.0).abs().maxCoeff(), 1e-10);
    // digits are lost with the cube of the distance
    EXPECT_LT((W.row(0) * cage.points() - points.row(0)).norm(), 1e-6);
}

TEST(MeanValue, leaves_out_faces_without_area)
{
    const SurfaceMesh cage = cages::cube_with_a_flat_triangle();
    const Points points = shapes::points_around(cage, 100, 1.2);
    EXPECT_LT(affine_error(cage, points), 1e-9);
    EXPECT_TRUE(weights_of(cage, shapes::points_near(cage, {0.0, 1e-9})).allFinite());
}

} // namespace sinew::test_mean_value
