// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/propagation.h"

#include "native/operators/laplacian.h"
#include "tests/native/allocations.h"
#include "tests/native/dense.h"
#include "tests/native/methods/surface/contract.h"
#include "tests/native/methods/surface/linear/study_tube.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sinew::test_propagation {

namespace {

const Poses bent{shapes::still(), shapes::turn({0, 1, 0}, 40, {6, 0, 0}, {-1, 0.5, 2})};

auto maker(const PropagationOptions& options)
{
    return [options](const SurfaceMesh& mesh) { return std::make_shared<Propagation>(mesh, options); };
}

Points solved(const SurfaceMesh& mesh, const std::vector<Handle>& handles, const SolveRequest& request,
              const PropagationOptions& options = {})
{
    Propagation propagation(mesh, options);
    propagation.set_handles(handles);
    Points positions;
    propagation.solve(request, positions);
    return positions;
}

SurfaceTraits traits()
{
    const auto drag = [](double t) {
        const double angle = 2 * shapes::pi * t;
        return Poses{shapes::still(), shapes::turn({0, 1, 0}, 60 * std::sin(angle), {9, 4, 0},
                                                   {2 * std::cos(angle) - 2, std::sin(angle), 0})};
    };
    return {.name = "Propagation",
            .variants = {{"harmonic", maker({})},
                         {"geodesic", maker({.field = Field::geodesic}), 0},
                         {"euclidean", maker({.field = Field::euclidean}), 0}},
            .mesh = shapes::hill(8, 8),
            .large = shapes::hill(10, 9),
            .depth = 1.5,
            .bent = bent,
            .drag = drag,
            .drag_steps = 48,
            .follow = 2.0, // what lies behind the handle turns about its centre, too
            .slack = 0.0,
            .translation = 1e-12,
            .rigid = 1e-13,
            .similar = 1e-10,
            .scaled = 1e-10,
            .updates = "transfer",
            .updated = maker({.transfer = {0.0, 0.2, 1.0}})};
}

/// The harmonic field of the second of two handles, by dense matrices.
VectorX harmonic_field(const SurfaceMesh& mesh, const std::vector<Handle>& handles)
{
    const int n = mesh.vertex_count();
    MatrixX A = dense::with_positive_weights(laplacian_matrix(mesh, Discretization::cotan));
    VectorX b = VectorX::Zero(n);
    for (int h : {0, 1})
        for (int v : handles[h].vertices) {
            A.row(v) = VectorX::Unit(n, v).transpose();
            b[v] = h;
        }
    return dense::solution(A, b);
}

} // namespace

INSTANTIATE_TEST_SUITE_P(Propagation, SurfaceContract, testing::Values(traits()));

TEST(Propagation, damps_rotation_scale_and_move_apart_about_the_centre_of_the_handle)
{
    shapes::Random random(7);
    const SurfaceMesh mesh = shapes::hill(8, 8);
    std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const VectorX field = harmonic_field(mesh, handles);
    Vector3 centre = Vector3::Zero();
    for (int v : handles[1].vertices)
        centre += mesh.point(v) / static_cast<double>(handles[1].vertices.size());
    for (const auto& curve :
         {std::vector{0.0, 1.0}, std::vector{0.0, 0.1, 1.0}, std::vector{0.0, 1.0, 1.0, 1.0}})
        for (double degrees : {0.0, 40.0, 170.0}) {
            const Matrix3 A = random.matrix(), R = shapes::rotation(random.vector(), degrees),
                          S = Matrix3::Identity() + 0.2 * (A + A.transpose());
            const Vector3 move = random.vector();
            const Pose pose = shapes::affine(R * S, centre + move - R * S * centre);
            const Points found =
                solved(mesh, handles, {.poses = {shapes::still(), pose}}, {.transfer = curve});
            for (int v = 0; v < mesh.vertex_count(); ++v) {
                const double place = field[v] * static_cast<double>(curve.size() - 1);
                const int k = std::clamp(static_cast<int>(place), 0, static_cast<int>(curve.size()) - 2);
                const double t = curve[k] + (place - k) * (curve[k + 1] - curve[k]);
                const Matrix3 turn =
                    Eigen::Quaterniond::Identity().slerp(t, Eigen::Quaterniond(R)).toRotationMatrix();
                const Vector3 expected =
                    centre + turn * (t * S + (1 - t) * Matrix3::Identity()) * (mesh.point(v) - centre) +
                    t * move;
                EXPECT_LT((found.row(v).transpose() - expected).norm(), 1e-11);
            }
        }
}

TEST(Propagation, twists_a_tube_evenly)
{
    const SurfaceMesh mesh = study_tube();
    for (Field field : {Field::harmonic, Field::geodesic, Field::euclidean}) {
        const Points q = solved(mesh, shapes::ends(mesh, 3.1),
                                {.poses = {shapes::still(), shapes::turn({1, 0, 0}, 135)}}, {.field = field});
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            const double s = std::clamp((mesh.point(v).x() - 3) / 14, 0.0, 1.0);
            EXPECT_LT((q.row(v).transpose() - shapes::rotation({1, 0, 0}, 135 * s) * mesh.point(v)).norm(),
                      1e-11);
        }
    }
}

TEST(Propagation, says_where_a_rule_chose_the_way_of_half_a_turn)
{
    const SurfaceMesh mesh = shapes::joined(shapes::hill(8, 8), shapes::sphere(1), {0, 20, 0});
    std::vector<Handle> handles = shapes::ends(shapes::hill(8, 8), 1.5);
    handles.push_back({{81}, {}});
    Propagation propagation(mesh);
    propagation.set_handles(handles);
    Points positions;
    const auto count = [&](double degrees) {
        const Poses poses{shapes::still(), shapes::turn({1, 2, 0}, degrees), shapes::still()};
        return propagation.solve({poses}, positions).half_turns;
    };
    EXPECT_EQ(count(179), 0);
    EXPECT_EQ(count(180), 81);
}

TEST(Propagation, one_affine_map_of_all_handles_is_exact_and_so_is_one_handle_alone)
{
    const SurfaceMesh mesh = shapes::hill(9, 8);
    Matrix3 A;
    A << 1.2, 0.3, 0, -0.4, 0.8, 0.1, 0.5, 0.2, -2; // it reflects
    const Pose pose = shapes::affine(A, {1, 2, 3});
    const Points expected = shapes::transformed(mesh.points(), pose);
    std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    handles.push_back({{45}, {0.3}});
    for (Field field : {Field::harmonic, Field::geodesic})
        EXPECT_LT(
            shapes::distance(solved(mesh, handles, {.poses = Poses(3, pose)}, {.field = field}), expected),
            1e-12);
    EXPECT_LT(shapes::distance(solved(mesh, {handles[2]}, {.poses = {pose}}, {.transfer = {0.0, 0.3, 1.0}}),
                               expected),
              1e-12);
}

TEST(Propagation, a_handle_that_rides_on_what_posed_the_mesh_does_not_turn_it_twice)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    const Pose pose = shapes::turn({1, 2, -0.5}, 120, {3, 7, 1}, {3, -2, 1});
    const Points incoming = shapes::transformed(mesh.points(), pose);
    const Points q = solved(mesh, shapes::ends(mesh, 1.5),
                            {.poses = {shapes::still(), pose},
                             .incoming = view(incoming),
                             .from_rest = std::vector<bool>{false, true}});
    EXPECT_LT(shapes::distance(q, incoming), 1e-12);
}

TEST(Propagation, refuses_curves_that_are_none)
{
    const SurfaceMesh mesh = shapes::cube();
    const auto make = [&](const std::vector<double>& curve) { Propagation(mesh, {.transfer = curve}); };
    EXPECT_THROW(make({}), InvalidOption);
    EXPECT_THROW(make({1.0}), InvalidOption);
    EXPECT_THROW(make({0.0, std::numeric_limits<double>::quiet_NaN(), 1.0}), InvalidOption);
}

TEST(Propagation, allocates_nothing_in_proportion_to_the_mesh_in_a_solve)
{
    if (!allocations::counted())
        GTEST_SKIP() << "nobody counts here";
    const SurfaceMesh mesh = shapes::hill(60, 60);
    Propagation propagation(mesh);
    propagation.set_handles(shapes::ends(mesh, 1.5));
    Points positions(mesh.vertex_count(), 3);
    const allocations::Count count(sizeof(double) * mesh.vertex_count());
    for (int k = 0; k < 3; ++k)
        propagation.solve({bent}, positions);
    EXPECT_EQ(count.so_far(), 0);
}

} // namespace sinew::test_propagation
