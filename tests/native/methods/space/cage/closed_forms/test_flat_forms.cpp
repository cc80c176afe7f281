// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/closed_forms/flat_forms.h"

#include "native/methods/space/cage/green.h"
#include "native/methods/space/cage/harmonic.h"
#include "native/methods/space/cage/mean_value.h"
#include "native/methods/space/cage/positive_mean_value.h"
#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_flat_forms {

namespace {

/// A concave polygon, as one face, turned and moved out of the axes.
Pose placed() { return shapes::turn({1, 2, -1}, 50, {0, 0, 0}, {3, -1, 2}); }

std::vector<Vector3> flag() { return {{0, 0, 0}, {4, 0, 0}, {4, 3, 0}, {2.5, 1, 0}, {1, 3, 0}, {0, 2.5, 0}}; }

SurfaceMesh polygon()
{
    const std::vector<Vector3> outline = flag();
    return shapes::mesh(outline, {{0, 1, 2, 3, 4, 5}});
}

SurfaceMesh tilted() { return shapes::moved(polygon(), shapes::transformed(polygon().points(), placed())); }

/// A square with a square hole, of eight faces.
SurfaceMesh ring() { return shapes::without_face(shapes::quad_grid(3, 3), 4); }

/// Places in a box around the flag, at heights of up to `height`.
Points around_flag(int count, double height, double reach = 0.3)
{
    shapes::Random random(1);
    Points p(count, 3);
    for (int i = 0; i < count; ++i)
        p.row(i) << -reach + (4 + 2 * reach) * random.unit(), -reach + (3 + 2 * reach) * random.unit(),
            height * random.signed_unit();
    return p;
}

template <class Method>
std::shared_ptr<Method> of(const SurfaceMesh& cage)
{
    if constexpr (std::is_same_v<Method, Green>)
        return std::make_shared<Green>(Cage(cage, true), GreenOptions{cages::doubles, {}, -1, {}});
    else
        return std::make_shared<Method>(Cage(cage, true), cages::doubles);
}

template <class Method>
SpaceTraits traits(const char* name)
{
    const SurfaceMesh cage = tilted();
    return {.name = name,
            .variants = {{name, [cage] { return of<Method>(cage); }}},
            .control = cage.points(),
            .points = shapes::transformed(around_flag(300, 0.5), placed()),
            .translation = 1e-12,
            .follow = 4.0,
            .other = [] { return of<Method>(polygon()); }};
}

template <class Method>
Points warped(const SurfaceMesh& cage, const Points& points, const Points& pose)
{
    const auto method = of<Method>(cage);
    method->bind(view(points));
    return warped_by(*method, view(pose));
}

template <class Method>
RowMatrix weights(const SurfaceMesh& cage, const Points& points)
{
    const auto method = of<Method>(cage);
    method->bind(view(points));
    return method->weights().dense();
}

} // namespace

INSTANTIATE_TEST_SUITE_P(Flat, SpaceContract,
                         testing::Values(traits<MeanValue>("MeanValue"), traits<Green>("Green")));

TEST(FlatMeanValue, has_the_known_weights_of_a_square)
{
    const SurfaceMesh square = shapes::quad_grid(1, 1);
    Points x(3, 3);
    x << 0.5, 0.5, 0, 0.5, 0, 0, 1, 1, 0;
    const RowMatrix w = weights<MeanValue>(square, x).leftCols(4);
    EXPECT_LT((w.row(0).array() - 0.25).abs().maxCoeff(), 1e-15);
    EXPECT_LT((w.row(1) - Eigen::RowVector4d(0.5, 0.5, 0, 0)).norm(), 1e-14);
    EXPECT_LT((w.row(2) - Eigen::RowVector4d(0, 0, 0, 1)).norm(), 1e-14);
}

TEST(FlatMeanValue, sums_to_one_with_linear_precision_also_outside_and_near_the_outline)
{
    for (const SurfaceMesh& cage : {polygon(), ring()}) {
        Points x(700, 3);
        x << around_flag(400, 0.0, 2.0), around_flag(300, 0.0);
        for (int i = 0; i < 300; ++i) { // beside edges and corners
            const int k = i % 6, j = (i / 6) % 6;
            const Vector3 a = cage.point(k), b = cage.point((k + 1) % 6);
            x.row(400 + i) = (a + 0.2 * j * (b - a)).transpose();
            x(400 + i, 0) += std::pow(10.0, -3.0 - 2.0 * (i % 7));
        }
        const RowMatrix w = weights<MeanValue>(cage, x);
        const auto vertices = w.leftCols(cage.vertex_count());
        EXPECT_LT((vertices.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
        EXPECT_LT((vertices * cage.points() - x).cwiseAbs().maxCoeff(), 1e-11);
    }
}

TEST(FlatMeanValue, is_the_same_map_as_the_oblong_cage_reproduces)
{
    const Pose pose = shapes::affine((Matrix3() << 1.3, 0.4, 0, -0.2, 0.8, 0, 0, 0, 1).finished(), {1, 2, 0});
    const Points x = around_flag(200, 0.0);
    EXPECT_LT(shapes::distance(warped<MeanValue>(polygon(), x, shapes::transformed(polygon().points(), pose)),
                               shapes::transformed(x, pose)),
              1e-12);
}

TEST(FlatGreen, is_conformal_inside)
{
    // Differences of the map satisfy the equations of Cauchy and Riemann for any pose in the plane.
    const SurfaceMesh cage = polygon();
    Points pose = cage.points();
    shapes::Random random(3);
    for (Eigen::Index v = 0; v < pose.rows(); ++v)
        pose.row(v).head<2>() += 0.5 * random.vector().head<2>().transpose();
    constexpr double h = 1e-5;
    const double places[][2] = {{0.5, 0.5}, {2, 0.7}, {3.6, 2}, {0.7, 2.2}};
    const int steps[][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    Points x(16, 3);
    for (int i = 0; i < 4; ++i)
        for (int k = 0; k < 4; ++k)
            x.row(4 * i + k) << places[i][0] + h * steps[k][0], places[i][1] + h * steps[k][1], 0;
    const Points y = warped<Green>(cage, x, pose), z = warped<MeanValue>(cage, x, pose);
    const auto defect = [&](const Points& p, int i) {
        const Eigen::RowVector3d dx = (p.row(4 * i) - p.row(4 * i + 1)) / (2 * h),
                                 dy = (p.row(4 * i + 2) - p.row(4 * i + 3)) / (2 * h);
        return std::hypot(dx[0] - dy[1], dx[1] + dy[0]);
    };
    double other = 0.0;
    for (int i = 0; i < 4; ++i) {
        EXPECT_LT(defect(y, i), 1e-8); // h^2, and rounding / h
        other = std::max(other, defect(z, i));
    }
    EXPECT_GT(other, 0.1) << "mean value is not";
}

TEST(FlatGreen, reproduces_similarities_in_the_plane_inside_outside_and_on_the_outline)
{
    for (const SurfaceMesh& cage : {polygon(), ring()}) {
        const Pose pose = shapes::affine(2.5 * shapes::rotation({0, 0, 1}, 130), {3, -1, 0});
        Points x(600, 3);
        x << around_flag(300, 0.0), around_flag(200, 0.0, 3.0), around_flag(100, 0.0);
        for (int i = 0; i < 100; ++i) {
            const int k = i % cage.vertex_count(), j = i / 20;
            const Vector3 a = cage.point(k), b = cage.point((k + 1) % cage.vertex_count());
            x.row(500 + i) = (a + 0.25 * j * (b - a)).transpose();
            x(500 + i, 1) += i % 2 ? 1e-13 : i % 3 ? -1e-9 : 0.0;
        }
        EXPECT_LT(shapes::distance(warped<Green>(cage, x, shapes::transformed(cage.points(), pose)),
                                   shapes::transformed(x, pose)),
                  1e-11);
    }
}

TEST(FlatForms, carry_points_over_the_plane_by_its_frame)
{
    const Pose pose = shapes::turn({3, -1, 2}, 75, {1, 2, 3}, {-4, 0, 2});
    const SurfaceMesh cage = tilted();
    const Points x = shapes::transformed(around_flag(300, 1.0), placed());
    const Points there = shapes::transformed(x, pose), moved = shapes::transformed(cage.points(), pose);
    EXPECT_LT(shapes::distance(warped<MeanValue>(cage, x, moved), there), 1e-13 * 20);
    EXPECT_LT(shapes::distance(warped<Green>(cage, x, moved), there), 1e-13 * 20);
    // Stretched in the plane, they keep their distance from it.
    Points wide = polygon().points();
    wide.col(0) *= 3.0;
    const Points high = around_flag(50, 1.0);
    EXPECT_LT((warped<MeanValue>(polygon(), high, wide).col(2) - high.col(2)).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LT((warped<Green>(polygon(), high, wide).col(2) - high.col(2)).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(FlatForms, know_what_is_outside)
{
    Points x(4, 3);
    x << 1, 1, 0, 2.5, 2, 0, 5, 1, 0, 2.5, 0.5, 3; // in, in the notch, beside, over the inside
    for (const auto& method :
         std::vector<std::shared_ptr<SpaceMethod>>{of<MeanValue>(polygon()), of<Green>(polygon())})
        EXPECT_EQ(method->bind(view(x)).outside, (std::vector<int>{1, 2}));
    Points hole(1, 3);
    hole << 1.5, 1.5, 0;
    EXPECT_EQ(of<Green>(ring())->bind(view(hole)).outside, std::vector<int>{0});
    EXPECT_THROW(Green(Cage(polygon(), true), GreenOptions{{}, GreenOutside::refuse, -1, {}}).bind(view(x)),
                 InvalidConstraint);
    EXPECT_THROW(Green(Cage(polygon(), true), GreenOptions{{}, GreenOutside::face, 0, {}}), InvalidOption);
}

TEST(FlatForms, take_poses_that_collapse)
{
    const Points x = around_flag(50, 0.3);
    for (const double factor : {0.0, 1e100, 1e-100}) {
        EXPECT_TRUE(warped<MeanValue>(polygon(), x, factor * polygon().points()).allFinite());
        EXPECT_TRUE(warped<Green>(polygon(), x, factor * polygon().points()).allFinite());
    }
    Points line = polygon().points();
    line.col(1).setZero();
    EXPECT_TRUE(warped<Green>(polygon(), x, line).allFinite());
    Points far(3, 3);
    far << 1e2, 3, 5, 1e100, -1e100, 3, 0, 0, -1e300;
    EXPECT_TRUE(weights<Green>(polygon(), far).allFinite());
    EXPECT_TRUE(weights<MeanValue>(polygon(), far).allFinite());
}

TEST(FlatForms, are_refused_by_methods_that_need_a_volume)
{
    expect_elements(refusal<InvalidMesh>([] { const Cage cage(polygon()); }), Error::Element::face, {0});
    EXPECT_FALSE(Harmonic::takes_flat);
    EXPECT_FALSE(PositiveMeanValue::takes_flat);
}

} // namespace sinew::test_flat_forms
