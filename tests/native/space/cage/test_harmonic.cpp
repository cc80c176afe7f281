// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/harmonic.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/space/cage/mean_value.h"
#include "tests/native/space/cage/cages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>

namespace sinew {

namespace {

constexpr PointWeightOptions doubles{WeightPrecision::double_precision, 0.0};

HarmonicOptions exact(HarmonicQuality quality = HarmonicQuality::fast)
{
    HarmonicOptions options;
    options.weights = doubles;
    options.quality = quality;
    return options;
}

RowMatrix weights(const SurfaceMesh& cage, const Points& points, const HarmonicOptions& options = exact())
{
    Harmonic harmonic(Cage(cage), options);
    harmonic.bind(view(points));
    return harmonic.weights().dense();
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

Points in_cube(int count)
{
    shapes::Random random(1);
    Points points(count, 3);
    for (Eigen::Index k = 0; k < points.size(); ++k)
        points.data()[k] = random.unit();
    return points;
}

double largest(const RowMatrix& matrix) { return matrix.cwiseAbs().maxCoeff(); }

/// Sum, linear precision and sign.
void expect_barycentric(const RowMatrix& w, const SurfaceMesh& cage, const Points& points)
{
    const double size = shapes::size(cage.points());
    EXPECT_LT((w.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
    EXPECT_LT(largest(w * cage.points() - points), 1e-9 * size); // points on the cage are found to 1e-10
    EXPECT_GE(w.minCoeff(), 0);
}

template <class Bind>
std::vector<int> named(Bind&& bind, Error::Element kind)
{
    try {
        bind();
    } catch (const Error& error) {
        EXPECT_EQ(error.element_kind(), kind) << error.what();
        return error.elements();
    }
    ADD_FAILURE() << "not refused";
    return {};
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

TEST(Harmonic, has_the_known_weights_in_the_octahedron)
{
    Points x(2, 3);
    x << 0.1, 0.2, 0.3, 0, 0, 0;
    const RowMatrix w = weights(shapes::octahedron(), x);
    RowMatrix known(1, 6);
    known << .19001, .09001, .26375, .06375, .34624, .04624;
    EXPECT_LT(largest(w.topRows(1) - known), 1.5e-5); // the digits given
    EXPECT_LT((w.row(1).array() - 1.0 / 6).abs().maxCoeff(), 1e-5);
}

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
    Points at(1, 3), before(1, 3);
    at << 0, 1.5, .5;
    for (double depth : {1e-9, 1e-7, 1e-5}) {
        before << depth, 1.5, .5;
        // The error of the coordinates on a plain face, far from its edges.
        EXPECT_LT(largest(weights(cages::u_prism(), at) - weights(cages::u_prism(), before)), 2e-3);
    }
}

TEST(Harmonic, agrees_with_walks_on_spheres)
{
    // Brownian motion from x leaves through the cage where its data are to be averaged: no equation is
    // solved.
    const SurfaceMesh u = cages::u_prism();
    Points x(2, 3);
    x << .5, 2.2, .4, 1.4, .6, .5;
    const RowMatrix w = weights(u, x, exact(HarmonicQuality::medium));
    constexpr int walks = 40000;
    shapes::Random random(5);
    for (int i = 0; i < 2; ++i) {
        Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(16);
        for (int walk = 0; walk < walks; ++walk) {
            Vector3 p = x.row(i).transpose();
            double radius = 1;
            int side = 0; // the wall that is nearest
            for (;;) {
                const double walls[] = {p.x(), 3 - p.x(), p.y(), p.z(), 1 - p.z()};
                side = static_cast<int>(std::min_element(walls, walls + 5) - walls);
                radius = walls[side];
                // The hollow 1 < x < 2, y > 1, and the two tops y = 3.
                const Vector3 nearest(std::clamp(p.x(), 1.0, 2.0), std::max(p.y(), 1.0), p.z());
                if ((nearest - p).norm() < radius) {
                    radius = (nearest - p).norm();
                    side = nearest.y() > 1 ? (p.x() < 1 ? 5 : 6) : 7;
                }
                if (3 - p.y() < radius) {
                    radius = 3 - p.y();
                    side = p.x() < 1 ? 8 : 9;
                }
                if (radius < 1e-4)
                    break;
                Vector3 step = random.vector();
                while (step.squaredNorm() > 1 || step.squaredNorm() < 1e-6)
                    step = random.vector();
                p += radius * step.normalized();
            }
            // Bilinear on the quads; the two caps of eight corners are left out of the comparison below.
            const auto quad = [&](int a, int b, double along) {
                along = std::clamp(along, 0.0, 1.0);
                mean[a] += (1 - along) * (1 - p.z());
                mean[b] += along * (1 - p.z());
                mean[8 + a] += (1 - along) * p.z();
                mean[8 + b] += along * p.z();
            };
            switch (side) {
            case 0:
                quad(7, 0, 1 - p.y() / 3);
                break;
            case 1:
                quad(1, 2, p.y() / 3);
                break;
            case 2:
                quad(0, 1, p.x() / 3);
                break;
            case 5:
                quad(5, 6, (p.y() - 1) / 2);
                break;
            case 6:
                quad(3, 4, 1 - (p.y() - 1) / 2);
                break;
            case 7:
                quad(4, 5, 2 - p.x());
                break;
            case 8:
                quad(6, 7, 1 - p.x());
                break;
            case 9:
                quad(2, 3, 3 - p.x());
                break;
            default: { // a cap: the triangle of SurfaceMesh that holds the point
                const double z = side == 3 ? 0 : 1;
                for (std::size_t t = 0; t < u.triangles().size(); ++t) {
                    const Triangle& corners = u.triangles()[t];
                    Matrix3 sides;
                    for (int k = 0; k < 3; ++k)
                        sides.col(k) << u.point(corners[k]).head<2>(), 1;
                    if (u.triangle_faces()[t] != (z == 0 ? 0 : 1))
                        continue;
                    const Vector3 hats = sides.inverse() * Vector3(p.x(), p.y(), 1);
                    if (hats.minCoeff() < -1e-3)
                        continue;
                    for (int k = 0; k < 3; ++k)
                        mean[corners[k]] += hats[k];
                    break;
                }
            }
            }
        }
        mean /= walks;
        // Four standard errors of a weight of variance 1/16 at most, and the shell of 1e-4.
        EXPECT_LT((mean - w.row(i)).cwiseAbs().maxCoeff(), 4 * .25 / std::sqrt(walks) + 1e-3);
    }
}

TEST(Harmonic, reports_an_error_that_shrinks_with_quality)
{
    const SurfaceMesh u = cages::u_prism();
    const Points x = cages::inside_u_prism(300, 0.02);
    Harmonic fast(Cage(u), exact(HarmonicQuality::fast)), fine(Cage(u), exact(HarmonicQuality::fine));
    const double fast_error = fast.bind(view(x)).error, fine_error = fine.bind(view(x)).error;
    const double difference = largest(fast.weights().dense() - fine.weights().dense());
    EXPECT_GT(fine.unknowns(), fast.unknowns());
    EXPECT_LT(fine.residual_rms(), 0.5 * fast.residual_rms());
    EXPECT_LT(fine_error, fast_error);
    EXPECT_LT(difference, 2 * fast_error);
    EXPECT_GT(difference, 0.02 * fast_error);
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
    Harmonic harmonic(Cage(shapes::cube()), exact());
    EXPECT_EQ(named([&] { harmonic.bind(view(x)); }, Error::Element::vertex), (std::vector<int>{1, 3}));
    HarmonicOptions options = exact();
    options.outside = CageOutside::mean_value;
    Harmonic both(Cage(shapes::cube()), options);
    EXPECT_EQ(both.bind(view(x)).outside, (std::vector<int>{1, 3}));
    MeanValue mean_value(Cage(shapes::cube()), doubles);
    mean_value.bind(view(x));
    for (int i : {1, 3})
        EXPECT_LT((both.weights().dense().row(i) - mean_value.weights().dense().row(i)).norm(), 1e-12);
    // The hollow of a U is outside, too.
    Points hollow(1, 3);
    hollow << 1.5, 2, .5;
    Harmonic u(Cage(cages::u_prism()), exact());
    EXPECT_EQ(named([&] { u.bind(view(hollow)); }, Error::Element::vertex), std::vector<int>{0});
}

TEST(Harmonic, names_faces_without_area)
{
    Points points = shapes::cube().points();
    points.row(6) = points.row(5); // face 3 and the top become triangles, half of each a line
    const SurfaceMesh flat = shapes::moved(shapes::cube(), points);
    const Points x = Points::Constant(1, 3, .25);
    Harmonic harmonic(Cage(flat), exact());
    const std::vector<int> faces = named([&] { harmonic.bind(view(x)); }, Error::Element::face);
    EXPECT_FALSE(faces.empty());
    for (int f : faces)
        EXPECT_TRUE(f == 1 || f == 3 || f == 4) << f;
}

TEST(Harmonic, names_faces_that_touch)
{
    const SurfaceMesh touching = shapes::joined(shapes::cube(), shapes::cube(), {1, 0, 0});
    const Points x = Points::Constant(1, 3, .25);
    Harmonic harmonic(Cage(touching), exact());
    EXPECT_EQ(named([&] { harmonic.bind(view(x)); }, Error::Element::face), (std::vector<int>{3, 11}));
}

TEST(Harmonic, stays_as_it_was_when_a_bind_is_cancelled_or_refused)
{
    const Points first = in_cube(10), second = in_cube(2000);
    Harmonic harmonic(Cage(shapes::cube()), exact());
    for (int last = 1; last < 200; ++last) {
        int ticks = 0;
        const Progress few([&](double fraction, const char*) {
            EXPECT_GE(fraction, 0);
            EXPECT_LE(fraction, 1);
            return ++ticks < last;
        });
        try {
            harmonic.bind(view(first), few);
            break;
        } catch (const Cancelled&) {
            EXPECT_EQ(harmonic.weights().point_count(), 0);
        }
        EXPECT_LT(last, 199);
    }
    const RowMatrix before = harmonic.weights().dense();
    EXPECT_THROW(harmonic.bind(view(second), Progress([](double, const char*) { return false; })), Cancelled);
    const Points outside = Points::Constant(1, 3, 2.0);
    EXPECT_THROW(harmonic.bind(view(outside)), InvalidConstraint);
    EXPECT_EQ(harmonic.weights().dense(), before);
}

TEST(Harmonic, tells_progress_that_never_falls)
{
    double last = 0;
    const Progress watch([&](double fraction, const char*) {
        EXPECT_GE(fraction, last);
        last = fraction;
        return true;
    });
    const Points x = in_cube(10000);
    Harmonic harmonic(Cage(shapes::cube()), exact());
    harmonic.bind(view(x), watch);
    EXPECT_EQ(last, 1);
}

TEST(Harmonic, is_refused_above_the_memory_limit)
{
    const Points x = in_cube(1);
    Harmonic harmonic(Cage(shapes::cube()), exact());
    limit_memory(1 << 20);
    EXPECT_THROW(harmonic.bind(view(x)), OutOfMemory);
    limit_memory(0);
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

} // namespace sinew
