// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/points/space_propagation.h"

#include "native/methods/surface/linear/propagation.h"
#include "tests/native/methods/space/contract.h"
#include "tests/native/methods/space/handle_points/fixture.h"
#include "tests/native/refusals.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_space_propagation {

namespace {

using handles::moved, handles::posed, handles::random_points, handles::regions, handles::three_poses,
    handles::warped;

SpaceTraits traits()
{
    const HandlePoints handles = regions(30);
    return {.name = "SpacePropagation",
            .variants = {{"straight", [=] { return std::make_shared<SpacePropagation>(handles); }},
                         {"eased",
                          [=] {
                              return std::make_shared<SpacePropagation>(
                                  handles, SpacePropagationOptions{{0.0, 0.1, 0.9, 1.0}});
                          }}},
            .control = handles.control(),
            .points = random_points(500, 3.0, 4),
            .translation{}, // not with another transfer, and affine maps are tested below
            .follow = 6.0,
            .other = [=] {
                return std::make_shared<SpacePropagation>(handles, SpacePropagationOptions{{0.0, 0.5, 1.0}});
            }};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(SpacePropagation, SpaceContract, testing::Values(traits()));

TEST(SpacePropagation, reproduces_affine_maps_of_all_handles)
{
    const HandlePoints handles = regions(30);
    const Points points = random_points(200, 3.0, 4);
    Matrix3 shear;
    shear << 1.2, 0.3, 0, -0.4, 0.8, 0.1, 0.5, 0.2, 2;
    SpacePropagation method(HandlePoints(view(handles.points()), {30, 31}));
    for (const Pose& pose : {shapes::shift(1, 2, 3), shapes::turn({1, 2, 3}, 60, {1, 1, 1}, {0, 1, 0}),
                             shapes::affine(shear, {1, 2, 3})})
        EXPECT_LT(shapes::distance(warped(method, points, posed(method.handles(), {pose, pose})),
                                   shapes::transformed(points, pose)),
                  1e-13 * 50);
}

TEST(SpacePropagation, is_that_of_a_surface_with_straight_distances)
{
    // The oracle knows a mesh and regions; both blend with the same loops, which the tests of that method
    // check.
    const SurfaceMesh mesh = shapes::bar(20, 3);
    const std::vector<Handle> ends = shapes::ends(mesh, 2.5);
    Propagation surface(mesh, {.field = Field::euclidean});
    surface.set_handles(ends);
    const Poses poses{shapes::still(), shapes::turn({0, 1, 0.2}, 70, {18, 1, 1}, {0, 1, 0})};
    SolveRequest request{.poses = poses};
    Points expected;
    surface.solve(request, expected);
    std::vector<int> counts;
    Points points(0, 3);
    for (const Handle& end : ends) {
        const auto before = points.rows();
        points.conservativeResize(before + static_cast<Eigen::Index>(end.vertices.size()), 3);
        for (std::size_t k = 0; k < end.vertices.size(); ++k)
            points.row(before + static_cast<Eigen::Index>(k)) = mesh.points().row(end.vertices[k]);
        counts.push_back(static_cast<int>(end.vertices.size()));
    }
    SpacePropagation space(HandlePoints(view(points), counts));
    EXPECT_LT(shapes::distance(warped(space, mesh.points(), posed(space.handles(), poses)), expected),
              1e-6 * 20) // shares in single precision
        << "in units of a bar of 20";
}

TEST(SpacePropagation, a_turn_fades_by_the_closed_form_of_two_handles)
{
    // x = c + slerp(I, R, t) (y - c) + t m with t = d_F / (d_F + d_H), here about z.
    Points places(6, 3);
    places << 0, 0, 0, 0, 1, 0, 0, 0, 1, 4, 0, 0, 4, 1, 0, 4, 0, 1;
    const HandlePoints handles(view(places), {3, 3});
    SpacePropagation method(handles);
    const Vector3 c = places.bottomRows(3).colwise().mean().transpose(), m(0.3, -0.2, 0.5);
    const Points points = random_points(60, 2.0, 3).rowwise() + Eigen::RowVector3d(2, 0, 0);
    const Points found =
        warped(method, points, posed(handles, {shapes::still(), shapes::turn({0, 0, 1}, 80, c, m)}));
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const auto away = [&](int first) {
            return (places.middleRows(first, 3).rowwise() - points.row(i)).rowwise().norm().minCoeff();
        };
        const double t = away(0) / (away(0) + away(3));
        const Vector3 y = points.row(i).transpose(),
                      expected = c + shapes::rotation({0, 0, 1}, 80 * t) * (y - c) + t * m;
        EXPECT_LT((found.row(i).transpose() - expected).norm(), 1e-6); // shares in single precision
    }
}

TEST(SpacePropagation, points_of_a_handle_go_where_it_takes_them)
{
    const HandlePoints handles = regions(30);
    SpacePropagation method(handles);
    EXPECT_LT(shapes::distance(warped(method, handles.points(), posed(handles, three_poses)),
                               moved(handles, three_poses)),
              1e-14 * 8);
}

TEST(SpacePropagation, refuses_what_makes_no_sense)
{
    EXPECT_THROW(SpacePropagation(regions(30), {{1.0}}), InvalidOption);
    EXPECT_THROW(SpacePropagation(regions(30), {{0.0, std::nan("")}}), InvalidOption);
    SpacePropagation method(regions(30));
    const MemoryLimit limit(100);
    EXPECT_THROW(method.bind(view(random_points(1000, 1.0, 1))), OutOfMemory);
}

} // namespace sinew::test_space_propagation
