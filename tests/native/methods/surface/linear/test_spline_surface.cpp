// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/spline_surface.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_spline_surface {

namespace {

class SplineSurface : public SurfaceFixture<sinew::SplineSurface, SplineSurfaceOptions>
{
public:
    /// x and y of the points, in which the meshes of the suite are graphs.
    static auto mapped(const SurfaceMesh& mesh)
    {
        return std::make_shared<Method>(
            mesh, Options{.degree = 2, .columns = 6, .rows = 5, .uv_map = mesh.points().leftCols(2)});
    }
    static SurfaceTraits traits()
    {
        SurfaceTraits made =
            linear("SplineSurface",
                   {{"plane", maker()},
                    {"map", mapped},
                    {"least squares", maker({.degree = 1, .columns = 4, .rows = 3, .smoothing = 0.0})}});
        made.translation = 1e-7;
        made.similar = made.scaled = 1e-6;
        made.many_enter = true;
        made.updates = "smoothing";
        made.updated = maker({.smoothing = 0.1});
        return made;
    }
};

} // namespace

INSTANTIATE_TEST_SUITE_P(SplineSurface, SurfaceContract, testing::Values(SplineSurface::traits()));

TEST_F(SplineSurface, has_a_flat_even_grid_over_a_flat_part_whose_points_move_with_the_handles)
{
    const SurfaceMesh flat = shapes::grid(12, 6);
    Method surface(flat, {.columns = 7, .rows = 5});
    EXPECT_TRUE(surface.control_grids({}).empty()) << "there are no handles yet";
    const std::vector<Handle> handles = shapes::ends(flat, 1.5);
    surface.set_handles(handles);
    const auto at_rest = surface.control_grids({.poses = Poses(2, shapes::still())});
    ASSERT_EQ(at_rest.size(), 1u);
    const auto& [columns, rows, points] = at_rest.front();
    EXPECT_EQ(columns, 7);
    EXPECT_EQ(rows, 5);
    // 4 and 2 spans bound the region, and the grid goes one span farther on each side.
    const Vector3 u = (points.row(1) - points.row(0)).transpose(),
                  v = (points.row(7) - points.row(0)).transpose();
    EXPECT_NEAR(u.norm(), 3.0, 1e-4);
    EXPECT_NEAR(v.norm(), 3.0, 1e-4);
    for (int j = 0; j < 5; ++j)
        for (int i = 0; i < 7; ++i)
            EXPECT_LT((points.row(7 * j + i).transpose() - points.row(0).transpose() - i * u - j * v).norm(),
                      1e-3);
    const auto moved = surface.control_grids({.poses = Poses(2, shapes::shift(1, 2, 3))});
    EXPECT_LT(shapes::distance(moved.front().points, points.rowwise() + Eigen::RowVector3d(1, 2, 3)), 1e-6);
    const Points lifted = flat.points().rowwise() + Eigen::RowVector3d(0, 0, 4);
    const auto entered =
        surface.control_grids({.poses = Poses(2, shapes::still()), .incoming = view(lifted)});
    EXPECT_LT(shapes::distance(entered.front().points, points.rowwise() + Eigen::RowVector3d(0, 0, 4)), 1e-6);
    EXPECT_THROW(surface.control_grids({.poses = Poses(1)}), InvalidConstraint);
}

TEST_F(SplineSurface, one_grid_point_moves_the_rectangle_of_its_degree_and_one_spans_and_nothing_else)
{
    const SurfaceMesh flat = shapes::grid(24, 20);
    const std::vector<Handle> handles{
        {shapes::where(flat, [](const Vector3& x) { return x.x() < 0.5; }), {}}};
    for (int degree = 1; degree <= 5; ++degree) {
        Method surface(flat, {.degree = degree, .columns = 12, .rows = 10});
        surface.set_handles(handles);
        const auto at_rest = surface.control_grids({.poses = Poses(1, shapes::still())});
        const Points& points = at_rest.front().points;
        const Vector3 u = (points.row(1) - points.row(0)).transpose(),
                      v = (points.row(12) - points.row(0)).transpose(), up(0.3, -0.2, 1.5);
        const int i = 6, j = 4, index = 12 * j + i;
        Points moves = Points::Zero(120, 3), positions;
        moves.row(index) = up.transpose();
        surface.solve({.poses = Poses(1, shapes::still()), .extra = GridMoves{view(moves)}}, positions);
        int inside = 0;
        for (int k = 0; k < flat.vertex_count(); ++k) {
            // In spans from the middle of the rectangle, by the grid that is shown.
            const Vector3 away = flat.point(k) - points.row(index).transpose();
            const double a = away.dot(u) / u.squaredNorm(), b = away.dot(v) / v.squaredNorm();
            const double reach = 0.5 * (degree + 1);
            const Vector3 moved = (positions.row(k) - flat.points().row(k)).transpose();
            if (std::max(std::abs(a), std::abs(b)) > reach + 1e-2) { // the shown grid fits to 1e-3
                EXPECT_LT(moved.norm(), 1e-13) << degree << " vertex " << k;
            } else if (std::max(std::abs(a), std::abs(b)) < reach - 0.5) {
                EXPECT_GT(moved.norm(), 0) << degree << " vertex " << k;
                EXPECT_LT(moved.cross(up).norm(), 1e-12) << "by a share of the move";
                ++inside;
            }
        }
        EXPECT_GT(inside, 3) << degree;
        const auto after =
            surface.control_grids({.poses = Poses(1, shapes::still()), .extra = GridMoves{view(moves)}});
        EXPECT_LT(shapes::distance(after.front().points, points + moves), 1e-14);
    }
}

TEST_F(SplineSurface, reaches_only_as_far_into_the_handles_as_the_margin)
{
    const SurfaceMesh mesh = shapes::grid(30, 4); // the free vertices lie within 4 of the middle
    std::vector<Handle> handles = shapes::ends(mesh, 10.5);
    std::erase_if(handles[1].vertices, [&](int v) { return mesh.point(v).x() > 22.5; });
    handles.push_back({shapes::where(mesh, [](const Vector3& x) { return x.x() > 22.5; }), {}});
    const Pose pose = shapes::turn({0, 1, 0}, 30, {20, 0, 0});
    const Poses alike{shapes::still(), pose, pose}, apart{shapes::still(), pose, shapes::still()};
    // The free vertices go 4.47 from their mean, and the third handle begins 4 from them.
    const auto change = [&](double margin) {
        const Points a = solved(mesh, handles, {.poses = alike}, {.margin = margin}),
                     b = solved(mesh, handles, {.poses = apart}, {.margin = margin});
        double most = 0.0;
        for (int v = 0; v < mesh.vertex_count(); ++v)
            if (mesh.point(v).x() < 22.5)
                most = std::max(most, (a.row(v) - b.row(v)).norm());
        return most;
    };
    EXPECT_LT(change(0.44), 1e-12);
    EXPECT_GT(change(0.46), 1e-3);
}

TEST_F(SplineSurface, names_vertices_without_a_place_on_the_map_where_a_grid_covers_them)
{
    const SurfaceMesh mesh = shapes::joined(shapes::hill(20, 4), shapes::hill(3, 3), {0, 20, 0});
    Options options{.margin = 0.0, .uv_map = mesh.points().leftCols(2)};
    options.uv_map.bottomRows(16).setConstant(nan); // of the part without a handle
    options.uv_map(0, 0) = nan; // and deep in a handle
    const std::vector<Handle> handles = shapes::ends(shapes::hill(20, 4), 4.5);
    Method surface(mesh, options);
    surface.set_handles(handles);
    Points before, after;
    surface.solve({bent}, before);
    options.uv_map(10, 1) = options.uv_map(31, 0) = nan;
    Method broken(mesh, options);
    expect_elements(refusal<InvalidOption>([&] { broken.set_handles(handles); }), Error::Element::vertex,
                    {10, 31});
    surface.solve({bent}, after);
    EXPECT_EQ(before, after);
}

TEST_F(SplineSurface, no_moves_of_grid_points_change_no_bit_and_moves_that_do_not_fit_are_refused)
{
    const SurfaceMesh mesh = shapes::joined(shapes::hill(14, 9), shapes::hill(14, 9), {0, 20, 0});
    const Method surface = bound(mesh, {.degree = 2, .columns = 6, .rows = 5, .margin = 9.0},
                                 calls::softened(shapes::ends(mesh, 2.5), 0.6));
    const Points none = Points::Zero(60, 3), few = Points::Zero(59, 3); // two grids
    EXPECT_EQ(solve(surface, bent, {.extra = GridMoves{view(none)}}).positions,
              solve(surface, bent).positions);
    Points broken = none;
    broken(7, 1) = nan;
    EXPECT_THROW(solve(surface, bent, {.extra = GridMoves{view(few)}}), InvalidConstraint);
    EXPECT_THROW(solve(surface, bent, {.extra = GridMoves{view(broken)}}), InvalidConstraint);
    EXPECT_THROW(surface.control_grids({.poses = bent, .extra = GridMoves{view(few)}}), InvalidConstraint);
}

TEST_F(SplineSurface, refuses_options_out_of_their_ranges)
{
    expect_refused(shapes::hill(3, 3), {{.degree = 0},
                                        {.degree = 6},
                                        {.columns = 1},
                                        {.rows = 33},
                                        {.smoothing = -1.0},
                                        {.margin = nan},
                                        {.uv_map = RowMatrix::Zero(16, 3)},
                                        {.uv_map = RowMatrix::Zero(15, 2)},
                                        {.uv_map = RowMatrix::Constant(16, 2, infinity)}});
}

} // namespace sinew::test_spline_surface
