// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/responses/implicit_response.h"

#include "native/methods/surface/linear/thin_shell.h"
#include "native/methods/surface/substeps.h"
#include "native/operators/laplacian.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_implicit_response {

namespace {

/// What a bind computes before.
struct Operators
{
    explicit Operators(const SurfaceMesh& mesh)
        : rest(mesh), L(laplacian_matrix(mesh, Discretization::cotan_voronoi, {}, least_area_for_order(2))),
          mass(divisible_mass(mesh, Discretization::cotan_voronoi, least_area_for_order(2))),
          delta(mass.cwiseInverse().asDiagonal() * (L * mesh.points()))
    {
        for (int v = 0; v < mesh.vertex_count(); ++v)
            rings.push_back(ring_at(L, view(mesh.points()), v));
    }

    SparseMatrix residual() const { return implicit_residual(rest, L, mass, rings, delta); }

    /// Of handles seen from a frame; without the translation of the whole.
    Points displaced(const std::vector<Handle>& handles, const Poses& poses,
                     const Matrix3& frame = Matrix3::Identity()) const
    {
        return centred(response(handles, poses, frame));
    }

    Points response(const std::vector<Handle>& handles, const Poses& poses, const Matrix3& frame) const
    {
        const Components parts = connected_components(rest);
        const Regions regions(handles, parts);
        const ImplicitResponse response(rest, L, mass, rings, delta, regions, HandleGroups(regions, parts));
        RowMatrix d;
        response.displace({poses, view(rest.points()), {}, nullptr}, {frame}, d);
        return d.reshaped<Eigen::RowMajor>(rest.vertex_count(), 3);
    }

    static Points centred(Points d)
    {
        d.rowwise() -= d.colwise().mean().eval();
        return d;
    }

    const SurfaceMesh& rest;
    SparseMatrix L;
    VectorX mass;
    Points delta;
    std::vector<Ring> rings;
};

VectorX rows_of(const Points& points) { return points.reshaped<Eigen::RowMajor>(); }

} // namespace

TEST(ImplicitResponse, vanishes_for_translations_and_scales_and_misses_rotations_by_1_minus_cos)
{
    const SurfaceMesh ball = shapes::sphere(3),
                      mesh = shapes::moved(ball, shapes::Random(2).shaken(ball.points(), 0.03));
    const Operators operators(mesh);
    const SparseMatrix A = operators.residual();
    const double unit = operators.delta.norm();
    const auto residual = [&](const Points& x) { return (A * rows_of(x)).norm() / unit; };
    const Points& x = mesh.points();
    EXPECT_LT(residual(x), 1e-11);
    EXPECT_LT(residual(x.rowwise() + Eigen::RowVector3d(3, -2, 5)), 1e-10);
    EXPECT_LT(residual(1.7 * x), 1e-11);
    const Vector3 axis(.3, -.5, .8);
    const auto constant = [&](double angle) {
        const Points turned = shapes::transformed(x, shapes::turn(axis, angle * 180 / shapes::pi));
        return residual(turned) / (1 - std::cos(angle));
    };
    for (double angle : {.01, .1, 2.0})
        EXPECT_NEAR(constant(angle) / constant(1.0), 1.0, 1e-6);
}

TEST(ImplicitResponse, is_linear_in_the_poses_and_scales_with_all_handles)
{
    const SurfaceMesh mesh = shapes::hill(9, 8);
    const Operators operators(mesh);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const Pose one = shapes::turn({0, 1, 0}, 50, {6, 0, 0}, {-1, 0.5, 2}),
               other = shapes::turn({1, 2, 0}, 130, {2, 0, 1});
    const auto of = [&](const Pose& pose) { return operators.displaced(handles, {shapes::still(), pose}); };
    EXPECT_LT(shapes::distance(of(0.3 * one + 0.7 * other), 0.3 * of(one) + 0.7 * of(other)), 1e-10);
    const Pose scale = shapes::affine(1.7 * Matrix3::Identity());
    EXPECT_LT(shapes::distance(operators.displaced(handles, {scale, scale}),
                               Operators::centred(0.7 * mesh.points())),
              1e-5)
        << "but for the weight of the second term of the energy";
}

TEST(ImplicitResponse, lifts_a_flat_plate_as_the_thin_shell_does)
{
    const SurfaceMesh plate = shapes::grid(12, 11, .5, .2);
    const std::vector<Handle> handles = shapes::ends(plate, 1.1);
    const Poses lifted{shapes::still(), shapes::shift(.1, .2, .4)};
    ThinShell shell(plate);
    shell.set_handles(handles);
    Points expected;
    shell.solve({lifted}, expected);
    const Points found = Operators(plate).displaced(handles, lifted);
    EXPECT_LT((found - Operators::centred(expected - plate.points())).col(2).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(ImplicitResponse, substeps_with_its_equations_kept_add_up_to_one)
{
    const SurfaceMesh mesh = shapes::bar(12, 2);
    const Operators operators(mesh);
    const std::vector<Handle> handles = shapes::ends(mesh, 3.1);
    const Poses twisted{shapes::still(), shapes::turn({1, 0, 0}, 135)};
    const PathOfPoses path(twisted, Vector3::Zero());
    Points sum = Points::Zero(mesh.vertex_count(), 3);
    for (int k = 1; k <= 4; ++k) {
        Poses step = path.at(k / 4.0);
        const Poses before = path.at((k - 1) / 4.0);
        for (int h = 0; h < 2; ++h)
            step[h] += shapes::still() - before[h];
        sum += operators.displaced(handles, step);
    }
    EXPECT_LT(shapes::distance(sum, operators.displaced(handles, twisted)), 1e-9);
}

} // namespace sinew::test_implicit_response
