// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/harmonic.h"

#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

#include <vector>

namespace sinew::test_harmonic {

namespace {

using cages::doubles;
using cages::in_cube;
using cages::largest;

HarmonicOptions exact(HarmonicQuality quality = HarmonicQuality::fast)
{
    HarmonicOptions options;
    options.weights = doubles;
    options.quality = quality;
    return options;
}

RowMatrix weights(const SurfaceMesh& cage, const Points& points, const HarmonicOptions& options = exact())
{
    return cages::weights<Harmonic>(cage, points, options);
}

/// Of the vertices of shapes::cube().
RowMatrix trilinear(const Points& points)
{
    RowMatrix expected(points.rows(), 8);
    const Points corners = shapes::cube().points();
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        for (int v = 0; v < 8; ++v) {
            expected(i, v) = 1;
            for (int k = 0; k < 3; ++k)
                expected(i, v) *= corners(v, k) > 0.5 ? points(i, k) : 1 - points(i, k);
        }
    return expected;
}

void expect_barycentric(const RowMatrix& w, const SurfaceMesh& cage, const Points& points)
{
    cages::expect_barycentric(w, cage, points, 1e-9); // points on the cage are found to 1e-10
}

/// The faces that a bind at the middle of the first cube is refused for.
std::vector<int> named_faces(const SurfaceMesh& cage)
{
    const auto error = refusal<Error>([&] { weights(cage, Points::Constant(1, 3, .25)); });
    EXPECT_EQ(error.element_kind(), Error::Element::face) << error.what();
    return error.elements();
}

SpaceTraits traits()
{
    const SurfaceMesh u = cages::u_prism();
    return {.name = "Harmonic",
            .variants = {cages::variant<Harmonic>("boundary", u, exact())},
            .control = u.points(),
            .points = cages::inside_u_prism(600, 1e-3),
            .affine = 2e-10,
            .outside = Vector3(1.5, 2, 0.5),
            .refuses_outside = true,
            .other = [u] { return std::make_shared<Harmonic>(Cage(u), exact(HarmonicQuality::medium)); }};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(Harmonic, SpaceContract, testing::Values(traits()));

TEST(Harmonic, is_trilinear_in_a_cube_of_quads)
{
    const Points x = in_cube(500);
    Points corner(1, 3);
    corner << .3, .4, .5;
    EXPECT_NEAR(weights(shapes::cube(), corner)(0, 6), 0.06, 2e-5);
    for (auto quality : {HarmonicQuality::fast, HarmonicQuality::medium}) {
        const RowMatrix w = weights(shapes::cube(), x, exact(quality));
        EXPECT_LT(largest(w - trilinear(x)), 1e-4); // a thirtieth of what a grid of Blender's stalls at
        expect_barycentric(w, shapes::cube(), x);
    }
}

TEST(Harmonic, is_barycentric_in_concave_cages_and_close_to_them)
{
    const SurfaceMesh u = cages::u_prism();
    for (double depth : {0.02, 1e-6}) {
        const Points x = cages::inside_u_prism(400, depth);
        expect_barycentric(weights(u, x), u, x);
    }
    for (std::uint64_t seed : {1, 2, 3}) {
        const SurfaceMesh cage = cages::bumpy(1, 0.5, seed);
        const Points x = cages::in_ball(200, 0.25, seed);
        expect_barycentric(weights(cage, x), cage, x);
    }
}

TEST(Harmonic, gives_the_data_on_the_cage)
{
    const SurfaceMesh u = cages::u_prism();
    const RowMatrix at_vertices = weights(u, u.points());
    EXPECT_LT(largest(at_vertices - RowMatrix::Identity(16, 16)), 1e-9);
    Points x(3, 3);
    x << 1.5, 0, 0, /* an edge of a side */ 0, 1.5, .5, /* the middle of a quad */ 1.2, .2, 1;
    const RowMatrix w = weights(u, x);
    expect_barycentric(w, u, x);
    EXPECT_NEAR(w(0, 0), .5, 1e-9);
    EXPECT_NEAR(w(0, 1), .5, 1e-9);
    for (int v : {0, 7, 8, 15}) // bilinear, not linear on two triangles
        EXPECT_NEAR(w(1, v), .25, 1e-9);
}

TEST(Harmonic, comes_to_the_data_as_the_cage_is_neared)
{
    Points x(4, 3);
    x << 0, 1.5, .5, 1e-9, 1.5, .5, 1e-7, 1.5, .5, 1e-5, 1.5, .5;
    const RowMatrix w = weights(cages::u_prism(), x);
    // The error of the coordinates on a plain face, far from its edges.
    EXPECT_LT(largest(w.bottomRows(3).rowwise() - w.row(0)), 2e-3);
}

TEST(Harmonic, has_no_extremum_inside)
{
    const Points x = cages::inside_u_prism(500, 0.05);
    const RowMatrix w = weights(cages::u_prism(), x);
    EXPECT_LT(w.maxCoeff(), 1);
    // The mean over a small ball is the value at its centre.
    constexpr double step = 0.02;
    Points star(7, 3);
    star.rowwise() = Eigen::RowVector3d(.5, 1.7, .5);
    for (int k = 0; k < 3; ++k) {
        star(1 + 2 * k, k) += step;
        star(2 + 2 * k, k) -= step;
    }
    const RowMatrix around = weights(cages::u_prism(), star);
    const Eigen::RowVectorXd laplacian = around.bottomRows(6).colwise().sum() - 6 * around.row(0);
    // The mend adds what is not harmonic, of the order of the error.
    EXPECT_LT(laplacian.cwiseAbs().maxCoeff(), 1e-4 * 6);
}

TEST(Harmonic, keeps_parts_of_a_cage_apart)
{
    const SurfaceMesh two = shapes::joined(shapes::cube(), shapes::cube(), {1.5, 0, 0});
    Points x = in_cube(100);
    x.bottomRows(50).col(0).array() += 1.5;
    const RowMatrix w = weights(two, x);
    Points second = x.bottomRows(50);
    second.col(0).array() -= 1.5;
    EXPECT_LT(largest(w.topLeftCorner(50, 8) - trilinear(x.topRows(50))), 1e-3);
    EXPECT_LT(largest(w.bottomRightCorner(50, 8) - trilinear(second)), 1e-3);
    EXPECT_LT(largest(w.topRightCorner(50, 8)), 1e-3);
    expect_barycentric(w, two, x);
}

TEST(Harmonic, names_points_outside_or_falls_back_on_mean_values)
{
    Points x(4, 3);
    x << .5, .5, .5, 2, .5, .5, .2, .9, .4, .5, .5, -.1;
    cages::expect_outside<Harmonic>(shapes::cube(), exact(), x, {1, 3});
}

TEST(Harmonic, names_faces_without_area)
{
    Points points = shapes::cube().points();
    points.row(6) = points.row(5); // face 3 and the top become triangles, half of each a line
    const std::vector<int> faces = named_faces(shapes::moved(shapes::cube(), points));
    EXPECT_FALSE(faces.empty());
    for (int f : faces)
        EXPECT_TRUE(f == 1 || f == 3 || f == 4) << f;
}

TEST(Harmonic, names_faces_that_touch)
{
    EXPECT_EQ(named_faces(shapes::joined(shapes::cube(), shapes::cube(), {1, 0, 0})), (std::vector{3, 11}));
}

TEST(Harmonic, is_refused_above_the_memory_limit)
{
    const Points x = in_cube(1);
    Harmonic harmonic(Cage(shapes::cube()), exact());
    {
        const MemoryLimit limit(1 << 20);
        EXPECT_THROW(harmonic.bind(view(x)), OutOfMemory);
    }
    EXPECT_NO_THROW(harmonic.bind(view(x)));
}

TEST(Harmonic, does_not_depend_on_units_or_place)
{
    const SurfaceMesh cage = cages::bumpy(1, 0.5, 1);
    const Points x = cages::in_ball(100, 0.25);
    const Pose pose = shapes::affine(1e-3 * shapes::rotation({1, 2, 3}, 40), {5, -7, 2});
    const RowMatrix here = weights(cage, x);
    const RowMatrix there =
        weights(shapes::moved(cage, shapes::transformed(cage.points(), pose)), shapes::transformed(x, pose));
    EXPECT_LT(largest(here - there),
              1e-6); // rounding of points to 1e-13 of the cage, and a system of condition 1e4
}

} // namespace sinew::test_harmonic
