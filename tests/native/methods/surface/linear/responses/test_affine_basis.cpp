// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/responses/affine_basis.h"

#include "native/core/errors.h"
#include "native/methods/surface/linear/thin_shell.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <limits>

namespace sinew::test_affine_basis {

namespace {

struct Pair
{
    ThinShell with, without;
};

Pair bind(const SurfaceMesh& mesh, ThinShellOptions options, const std::vector<Handle>& handles)
{
    options.affine_basis = true;
    ThinShell with(mesh, options);
    options.affine_basis = false;
    ThinShell without(mesh, options);
    with.set_handles(handles);
    without.set_handles(handles);
    return {std::move(with), std::move(without)};
}

/// \param tolerance  of the positions, a share of the size: as methods.md asks.
void expect_the_same(const Pair& pair, const Poses& poses, double tolerance = 1e-10)
{
    Points quick, full;
    const SolveReport a = pair.with.solve({poses}, quick), b = pair.without.solve({poses}, full);
    EXPECT_LE(shapes::distance(quick, full), tolerance * shapes::size(full));
    EXPECT_NEAR(a.energy, b.energy, 1e-9 * b.energy);
}

Poses random_poses(int count, int seed)
{
    shapes::Random random(seed);
    Poses poses;
    for (int h = 0; h < count; ++h) {
        const Matrix3 A = random.matrix() + Matrix3::Identity();
        poses.push_back(shapes::affine(A, 3 * random.vector()));
    }
    return poses;
}

std::vector<Handle> three_handles(const SurfaceMesh& mesh)
{
    std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    handles.push_back({{40, 41, 49, 50}, {0.5, 0.3, 0.9, 1.0}});
    return handles;
}

} // namespace

TEST(AffineBasis, functions_of_all_handles_and_the_fixed_one_sum_to_one)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    const Pair pair = bind(mesh, {}, three_handles(mesh));
    const auto& B = pair.with.affine_basis()->matrix();
    ASSERT_EQ(B.rows(), mesh.vertex_count());
    ASSERT_EQ(B.cols(), 12);
    const VectorX sum = B.col(3) + B.col(7) + B.col(11);
    EXPECT_LT((sum.array() - 1).abs().maxCoeff(), 1e-9); // a solve of condition 1e5
}

TEST(AffineBasis, is_the_rest_shape_on_its_own_handle_and_zero_on_the_others)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const Pair pair = bind(mesh, {}, handles);
    const auto& B = pair.with.affine_basis()->matrix();
    for (int h : {0, 1})
        for (int v : handles[h].vertices) {
            EXPECT_EQ((B.block<1, 3>(v, 4 * h)), mesh.points().row(v));
            EXPECT_EQ(B(v, 4 * h + 3), 1.0);
            EXPECT_EQ((B.block<1, 4>(v, 4 - 4 * h).cwiseAbs().maxCoeff()), 0.0);
        }
}

TEST(AffineBasis, is_zero_in_parts_without_a_handle)
{
    const SurfaceMesh first = shapes::hill(6, 6);
    const SurfaceMesh mesh = shapes::joined(first, shapes::cube(), {30, 0, 0});
    const Pair pair = bind(mesh, {}, shapes::ends(first, 1.5));
    EXPECT_EQ(pair.with.affine_basis()->matrix().bottomRows(8).cwiseAbs().maxCoeff(), 0.0);
}

TEST(AffineBasis, leaves_parts_without_a_handle_alone_where_others_place_them)
{
    const SurfaceMesh first = shapes::hill(6, 6);
    const SurfaceMesh mesh = shapes::joined(shapes::cube(), first, {30, 0, 0}); // the cube comes first
    std::vector<Handle> handles = shapes::ends(first, 1.5);
    for (Handle& handle : handles)
        for (int& vertex : handle.vertices)
            vertex += 8;
    const Pair pair = bind(mesh, {}, handles);
    const Poses poses = random_poses(2, 5);
    Points all, moved = Points::Constant(mesh.vertex_count(), 3, 7.0);
    pair.with.affine_basis()->solve(poses, all);
    pair.with.affine_basis()->solve(poses, moved, false);
    EXPECT_EQ(all.topRows(8), mesh.points().topRows(8));
    EXPECT_EQ(moved.topRows(8), Points::Constant(8, 3, 7.0));
    EXPECT_EQ(moved.bottomRows(first.vertex_count()), all.bottomRows(first.vertex_count()));
}

TEST(AffineBasis, is_left_out_where_handles_are_many)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    std::vector<Handle> handles;
    for (int v = 0; v < 17; ++v)
        handles.push_back({{4 * v}, {}});
    const Pair pair = bind(mesh, {}, handles);
    EXPECT_EQ(pair.with.affine_basis(), nullptr);
    const Poses poses = random_poses(17, 1);
    expect_the_same(pair, poses, 0.0);
    // It can still be built by hand.
    Points a, b;
    pair.without.solve({poses}, b);
    const MatrixX columns = AffineBasis::columns(mesh.points(), pair.with.regions());
    AffineBasis(mesh.points(), pair.with.respond(columns), pair.with.regions()).solve(poses, a);
    EXPECT_LT(shapes::distance(a, b), 1e-10 * shapes::size(b));
}

TEST(AffineBasis, follows_another_stiffness)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    Pair pair = bind(mesh, {}, shapes::ends(mesh, 1.5));
    pair.with.set_stiffness({5.0}, {0.1}, {0.0});
    pair.without.set_stiffness({5.0}, {0.1}, {0.0});
    expect_the_same(pair, random_poses(2, 3));
}

TEST(AffineBasis, refuses_poses_that_do_not_fit)
{
    const SurfaceMesh mesh = shapes::hill(6, 6);
    const Pair pair = bind(mesh, {}, shapes::ends(mesh, 1.5));
    const AffineBasis& basis = *pair.with.affine_basis();
    Points out;
    EXPECT_THROW(basis.solve({shapes::still()}, out), InvalidConstraint);
    Poses bad(2, shapes::still());
    bad[0](1, 1) = std::numeric_limits<double>::infinity();
    EXPECT_THROW(basis.solve(bad, out), InvalidConstraint);
}

} // namespace sinew::test_affine_basis
