// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/responses/affine_basis.h"

#include "native/core/errors.h"
#include "native/methods/surface/linear/thin_shell.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <limits>

namespace sinew::test_affine_basis {

// That a shell solves by it as without it is in tests/bindings/oracles/test_oracles_surface.py.
TEST(AffineBasis, is_the_rest_shape_on_its_own_handle_zero_on_others_and_of_sum_one_where_handles_touch)
{
    const SurfaceMesh hill = shapes::hill(8, 8), mesh = shapes::joined(hill, shapes::cube(), {30, 0, 0});
    std::vector<Handle> handles = shapes::ends(hill, 1.5);
    ThinShell shell(mesh);
    shell.set_handles(handles);
    RowMatrix B = shell.affine_basis()->matrix();
    for (int h : {0, 1})
        for (int v : handles[h].vertices) {
            EXPECT_EQ((B.block<1, 3>(v, 4 * h)), mesh.points().row(v));
            EXPECT_EQ(B(v, 4 * h + 3), 1.0);
            EXPECT_EQ((B.block<1, 4>(v, 4 - 4 * h).cwiseAbs().maxCoeff()), 0.0);
        }
    handles.push_back({{40, 41, 49, 50}, {0.5, 0.3, 0.9, 1.0}});
    shell.set_handles(handles);
    B = shell.affine_basis()->matrix();
    ASSERT_EQ(B.cols(), 12);
    EXPECT_EQ(B.bottomRows(8).cwiseAbs().maxCoeff(), 0.0);
    const VectorX sum = B.col(3) + B.col(7) + B.col(11);
    EXPECT_LT((sum.head(hill.vertex_count()).array() - 1).abs().maxCoeff(), 1e-9); // a condition of 1e5
}

TEST(AffineBasis, leaves_parts_without_a_handle_alone_where_others_place_them_and_refuses_wrong_poses)
{
    const SurfaceMesh mesh = shapes::joined(shapes::cube(), shapes::hill(6, 6), {30, 0, 0});
    ThinShell shell(mesh);
    shell.set_handles({{{8, 9, 15, 16}, {}}, {{54, 55, 56}, {}}});
    const AffineBasis& basis = *shell.affine_basis();
    Poses poses{shapes::still(), shapes::turn({1, 2, 0}, 40, {36, 0, 0}, {1, 2, 3})};
    Points all, moved = Points::Constant(mesh.vertex_count(), 3, 7.0);
    basis.solve(poses, all);
    basis.solve(poses, moved, false);
    EXPECT_EQ(all.topRows(8), mesh.points().topRows(8));
    EXPECT_EQ(moved.topRows(8), Points::Constant(8, 3, 7.0));
    EXPECT_EQ(moved.bottomRows(49), all.bottomRows(49));
    EXPECT_THROW(basis.solve({shapes::still()}, all), InvalidConstraint);
    poses[0](1, 1) = std::numeric_limits<double>::infinity();
    EXPECT_THROW(basis.solve(poses, all), InvalidConstraint);
}

TEST(AffineBasis, is_left_out_where_handles_are_many_and_can_still_be_built_by_hand)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    std::vector<Handle> handles;
    Poses poses;
    for (int v = 0; v < 17; ++v) {
        handles.push_back({{4 * v}, {}});
        poses.push_back(shapes::turn({1, 2, 0}, 10.0 * v, {4, 4, 0}, {0, 0, 0.1 * v}));
    }
    ThinShell shell(mesh);
    shell.set_handles(handles);
    EXPECT_EQ(shell.affine_basis(), nullptr);
    Points a, b;
    shell.solve({poses}, b);
    const MatrixX columns = AffineBasis::columns(mesh.points(), shell.regions());
    AffineBasis(mesh.points(), shell.respond(columns), shell.regions()).solve(poses, a);
    EXPECT_LT(shapes::distance(a, b), 1e-10 * shapes::size(b));
}

} // namespace sinew::test_affine_basis
