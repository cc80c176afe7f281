// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/spline_surface.h"

#include "native/operators/laplacian.h"
#include "native/splines/bspline_basis.h"
#include "tests/native/allocations.h"
#include "tests/native/dense.h"
#include "tests/native/methods/surface/contract.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

namespace sinew::test_spline_surface {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
const Poses bent{shapes::still(), shapes::turn({0, 1, 0}, 40, {6, 0, 0}, {-1, 0.5, 2})};

auto maker(const SplineSurfaceOptions& options)
{
    return [options](const SurfaceMesh& mesh) { return std::make_shared<SplineSurface>(mesh, options); };
}

/// x and y of the points, in which the meshes of the suite are graphs.
auto mapped(const SurfaceMesh& mesh)
{
    return std::make_shared<SplineSurface>(
        mesh,
        SplineSurfaceOptions{.degree = 2, .columns = 6, .rows = 5, .uv_map = mesh.points().leftCols(2)});
}

Points solved(const SurfaceMesh& mesh, const std::vector<Handle>& handles, const SolveRequest& request,
              const SplineSurfaceOptions& options = {}, SolveReport* report = nullptr)
{
    SplineSurface surface(mesh, options);
    surface.set_handles(handles);
    Points positions;
    const SolveReport found = surface.solve(request, positions);
    if (report)
        *report = found;
    return positions;
}

/// (n, columns * rows) the weights of the control points at places of a map, of which the grid covers the
/// box.
MatrixX spline_weights(const MatrixX& uv, int degree, int columns, int rows)
{
    const BsplineBasis along_u(degree, columns), along_v(degree, rows);
    MatrixX B = MatrixX::Zero(uv.rows(), columns * rows);
    const Eigen::RowVector2d low = uv.colwise().minCoeff(), size = uv.colwise().maxCoeff() - low;
    for (Eigen::Index k = 0; k < uv.rows(); ++k) {
        std::array<double, 6> u, v;
        const int column = along_u.values((uv(k, 0) - low[0]) / size[0], u.data()),
                  row = along_v.values((uv(k, 1) - low[1]) / size[1], v.data());
        for (int j = 0; j <= degree; ++j)
            for (int i = 0; i <= degree; ++i)
                B(k, (row + j) * columns + column + i) = u[i] * v[j];
    }
    return B;
}

SurfaceTraits traits()
{
    const auto drag = [](double t) {
        const double angle = 2 * shapes::pi * t;
        return Poses{shapes::still(), shapes::turn({0, 1, 0}, 60 * std::sin(angle), {9, 4, 0},
                                                   {2 * std::cos(angle) - 2, std::sin(angle), 0})};
    };
    return {.name = "SplineSurface",
            .variants = {{"plane", maker({})},
                         {"map", mapped},
                         {"least squares", maker({.degree = 1, .columns = 4, .rows = 3, .smoothing = 0.0})}},
            .mesh = shapes::hill(8, 8),
            .large = shapes::hill(10, 9),
            .depth = 1.5,
            .bent = bent,
            .drag = drag,
            .drag_steps = 48,
            .follow = 2.0, // where the surface bends outwards, it goes farther than the handle
            .slack = 0.0,
            .translation = 1e-7,
            .similar = 1e-6,
            .scaled = 1e-6,
            .updates = "smoothing",
            .updated = maker({.smoothing = 0.1})};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(SplineSurface, SurfaceContract, testing::Values(traits()));

TEST(SplineSurface, of_few_constraints_is_the_spline_of_least_norm_over_the_map)
{
    const SurfaceMesh mesh = shapes::hill(20, 18);
    const MatrixX uv = shapes::Random(4).dense(mesh.vertex_count(), 2); // any map will do
    const std::vector<int> held{3, 50, 111, 205, 300, 388};
    std::vector<Handle> handles;
    Poses poses;
    MatrixX wanted(6, 3);
    shapes::Random random(5);
    for (int h = 0; h < 6; ++h) {
        handles.push_back({{held[h]}, {}});
        const Vector3 move = random.vector();
        poses.push_back(shapes::shift(move.x(), move.y(), move.z()));
        wanted.row(h) = move.transpose();
    }
    const Eigen::RowVector3d mean = wanted.colwise().mean();
    for (int degree = 1; degree <= 5; ++degree) {
        const MatrixX B = spline_weights(uv, degree, 9, 7), C = B(held, Eigen::all);
        const MatrixX c = C.transpose() * dense::solution(C * C.transpose(), wanted.rowwise() - mean);
        const Points expected = (mesh.points() + B * c).rowwise() + mean;
        SolveReport report;
        const Points found =
            solved(mesh, handles, {.poses = poses},
                   {.degree = degree, .columns = 9, .rows = 7, .smoothing = 0.0, .uv_map = uv}, &report);
        // C C^T has a condition number of up to 1e3, and the normal equation squares that of C.
        EXPECT_LT(shapes::distance(found, expected), 1e-9) << degree;
        EXPECT_LT(report.residual, 1e-10) << "the constraints are met";
        EXPECT_LT(report.energy, 1e-18) << "nothing is left to spread";
    }
}

TEST(SplineSurface, spreads_what_least_squares_miss_by_a_harmonic_field)
{
    const SurfaceMesh mesh = shapes::hill(14, 9);
    const int n = mesh.vertex_count();
    const MatrixX uv = mesh.points().leftCols(2), B = spline_weights(uv, 2, 4, 3);
    const MatrixX L = dense::with_positive_weights(laplacian_matrix(mesh, Discretization::cotan));
    const Poses poses{shapes::still(), shapes::turn({0.3, 1, 0.2}, 70, {12, 4, 0}, {-1, 0.5, 2})};
    for (double weight : {1.0, 0.6}) {
        std::vector<Handle> handles = shapes::ends(mesh, 2.5);
        handles[1].weights.assign(handles[1].vertices.size(), weight);
        MatrixX W = MatrixX::Zero(n, n), S = W, d = MatrixX::Zero(n, 3), h = d;
        std::vector<int> free;
        std::vector<double> of(n, 0.0);
        for (int k : {0, 1})
            for (int v : handles[k].vertices) {
                of[v] = k == 0 ? 1.0 : weight;
                W(v, v) = of[v] / static_cast<double>(handles[k].vertices.size());
                S(v, v) = of[v] < 1 ? of[v] / (1 - of[v]) * L(v, v) : 0.0;
                d.row(v) = (apply(poses[k], mesh.point(v)) - mesh.point(v)).transpose();
            }
        for (int v = 0; v < n; ++v)
            if (of[v] < 1)
                free.push_back(v);
        // Every handle is within the margin, and with both ends no control point is left open.
        const MatrixX c = dense::solution(B.transpose() * W * B, B.transpose() * W * d), gap = d - B * c;
        for (int v = 0; v < n; ++v)
            if (of[v] == 1)
                h.row(v) = gap.row(v);
        h = dense::solution(L + S, S * gap, h, free);
        const Points expected = mesh.points() + B * c + h;

        const SplineSurfaceOptions options{
            .degree = 2, .columns = 4, .rows = 3, .smoothing = 0.0, .margin = 9.0, .uv_map = uv};
        SolveReport report, other;
        const Points found = solved(mesh, handles, {.poses = poses}, options, &report),
                     again = solved(mesh, handles, {.poses = poses, .incoming = view(mesh.points())}, options,
                                    &other);
        // The normal equation has a condition number of 1e4.
        EXPECT_LT(shapes::distance(found, expected), 1e-10) << weight;
        EXPECT_LT(shapes::distance(again, expected), 1e-10) << "without the basis";
        const double missed =
            std::sqrt((gap.transpose() * W * gap).trace() / (d.transpose() * W * d).trace());
        EXPECT_GT(missed, 0.01);
        const double energy =
            0.5 * (h.transpose() * L * h).trace() + 0.5 * ((h - gap).transpose() * S * (h - gap)).trace();
        EXPECT_GT(energy, 1e-3);
        for (const SolveReport& told : {report, other}) {
            EXPECT_NEAR(told.residual, missed, 1e-10);
            EXPECT_NEAR(told.energy, energy, 1e-9 * energy);
        }
    }
}

TEST(SplineSurface, has_a_flat_even_grid_over_a_flat_part_whose_points_move_with_the_handles)
{
    const SurfaceMesh flat = shapes::grid(12, 6);
    SplineSurface surface(flat, {.columns = 7, .rows = 5});
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

TEST(SplineSurface, one_grid_point_moves_the_rectangle_of_its_degree_and_one_spans_and_nothing_else)
{
    const SurfaceMesh flat = shapes::grid(24, 20);
    const std::vector<Handle> handles{
        {shapes::where(flat, [](const Vector3& x) { return x.x() < 0.5; }), {}}};
    for (int degree = 1; degree <= 5; ++degree) {
        SplineSurface surface(flat, {.degree = degree, .columns = 12, .rows = 10});
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

TEST(SplineSurface, adds_the_spline_of_moved_grid_points_to_the_handles_and_holds_held_vertices)
{
    const SurfaceMesh mesh = shapes::joined(shapes::hill(14, 9), shapes::hill(14, 9), {0, 20, 0});
    const int n = mesh.vertex_count(), half = n / 2;
    std::vector<Handle> handles = shapes::ends(mesh, 2.5);
    handles[1].weights.assign(handles[1].vertices.size(), 0.6);
    const MatrixX uv = mesh.points().leftCols(2),
                  L = dense::with_positive_weights(laplacian_matrix(mesh, Discretization::cotan));
    const SplineSurfaceOptions options{.degree = 2, .columns = 6, .rows = 5, .margin = 9.0, .uv_map = uv};
    const Points moves = shapes::Random(3).dense(60, 3); // two grids
    MatrixX S = MatrixX::Zero(n, n), spline = MatrixX::Zero(n, 3), h = spline;
    for (int part : {0, 1})
        spline.middleRows(part * half, half) =
            spline_weights(uv.middleRows(part * half, half), 2, 6, 5) * moves.middleRows(30 * part, 30);
    std::vector<bool> hard(n, false);
    for (int v : handles[0].vertices) {
        hard[v] = true;
        h.row(v) = -spline.row(v);
    }
    for (int v : handles[1].vertices)
        S(v, v) = 0.6 / 0.4 * L(v, v);
    std::vector<int> free;
    for (int v = 0; v < n; ++v)
        if (!hard[v])
            free.push_back(v);
    h = dense::solution(L + S, -S * spline, h, free);
    const SolveRequest request{.poses = bent}, moved{.poses = bent, .extra = GridMoves{view(moves)}};
    const Points expected = solved(mesh, handles, request, options) + spline + h;
    EXPECT_LT(shapes::distance(solved(mesh, handles, moved, options), expected), 1e-10); // two factorisations
    const Points none = Points::Zero(60, 3);
    EXPECT_EQ(solved(mesh, handles, {.poses = bent, .extra = GridMoves{view(none)}}, options),
              solved(mesh, handles, request, options))
        << "to the last bit";

    SplineSurface surface(mesh, options);
    surface.set_handles(handles);
    Points positions;
    const Points few = Points::Zero(59, 3);
    EXPECT_THROW(surface.solve({.poses = bent, .extra = GridMoves{view(few)}}, positions), InvalidConstraint);
    Points broken = moves;
    broken(7, 1) = nan;
    EXPECT_THROW(surface.solve({.poses = bent, .extra = GridMoves{view(broken)}}, positions),
                 InvalidConstraint);
    EXPECT_THROW(surface.control_grids({.poses = bent, .extra = GridMoves{view(few)}}), InvalidConstraint);
}

TEST(SplineSurface, reaches_only_as_far_into_the_handles_as_the_margin)
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

TEST(SplineSurface, names_vertices_without_a_place_on_the_map_where_a_grid_covers_them)
{
    const SurfaceMesh mesh = shapes::joined(shapes::hill(20, 4), shapes::hill(3, 3), {0, 20, 0});
    SplineSurfaceOptions options{.margin = 0.0, .uv_map = mesh.points().leftCols(2)};
    options.uv_map.bottomRows(16).setConstant(nan); // of the part without a handle
    options.uv_map(0, 0) = nan; // and deep in a handle
    const std::vector<Handle> handles = shapes::ends(shapes::hill(20, 4), 4.5);
    SplineSurface surface(mesh, options);
    surface.set_handles(handles);
    Points before, after;
    surface.solve({bent}, before);
    options.uv_map(10, 1) = options.uv_map(31, 0) = nan;
    SplineSurface broken(mesh, options);
    expect_elements(refusal<InvalidOption>([&] { broken.set_handles(handles); }), Error::Element::vertex,
                    {10, 31});
    surface.solve({bent}, after);
    EXPECT_EQ(before, after);
}

TEST(SplineSurface, refuses_options_out_of_their_ranges)
{
    const SurfaceMesh mesh = shapes::hill(3, 3);
    const auto refused = [&](const SplineSurfaceOptions& options) {
        EXPECT_THROW(SplineSurface(mesh, options), InvalidOption);
    };
    refused({.degree = 0});
    refused({.degree = 6});
    refused({.columns = 1});
    refused({.rows = 33});
    refused({.smoothing = -1.0});
    refused({.margin = nan});
    refused({.uv_map = RowMatrix::Zero(16, 3)});
    refused({.uv_map = RowMatrix::Zero(15, 2)});
    refused({.uv_map = RowMatrix::Constant(16, 2, std::numeric_limits<double>::infinity())});
}

TEST(SplineSurface, solves_after_the_first_allocate_nothing_in_proportion_to_the_mesh)
{
    if (!allocations::counted())
        GTEST_SKIP() << "nobody counts here";
    const SurfaceMesh mesh = shapes::hill(60, 60);
    SplineSurface surface(mesh);
    surface.set_handles(shapes::ends(mesh, 1.5));
    Points positions;
    const allocations::Count count(sizeof(double) * mesh.vertex_count());
    const PointsView rest = view(mesh.points());
    surface.solve({.poses = bent, .incoming = rest}, positions);
    const int first = count.so_far();
    EXPECT_GT(first, 0);
    for (int k = 0; k < 3; ++k) {
        surface.solve({bent}, positions);
        surface.solve({.poses = bent, .incoming = rest}, positions);
    }
    EXPECT_EQ(count.so_far(), first);
}

} // namespace sinew::test_spline_surface
