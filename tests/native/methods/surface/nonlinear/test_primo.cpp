// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/primo.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <limits>

namespace sinew::test_primo {

namespace {

using calls::bend, calls::twist;

/// Each face cut into triangles.
SurfaceMesh triangulated(const SurfaceMesh& mesh)
{
    shapes::Polygons faces;
    for (const Triangle& t : mesh.triangles())
        faces.push_back({t[0], t[1], t[2]});
    return shapes::over(mesh.points(), faces);
}

double rms(const Points& a, const Points& b) { return std::sqrt((a - b).squaredNorm() / a.rows()); }

class Primo : public SurfaceFixture<sinew::Primo, PrimoOptions>
{
public:
    static SurfaceTraits traits()
    {
        SurfaceTraits made = nonlinear("Primo", {{"default", maker(), 2, false}, // a bind has one mean height
                                                 {"low", maker({.height = {0.005}}), 2, false},
                                                 {"high", maker({.height = {0.3}}), 2, false}});
        // Bodies get other numbers, so that it stops at another iteration, each within 1 % of how far the
        // surface moves.
        made.similar = 0.1;
        made.iterative = true;
        made.other = maker({.height = {0.1}});
        return made;
    }
};

} // namespace

INSTANTIATE_TEST_SUITE_P(Primo, SurfaceContract, testing::Values(Primo::traits()));

TEST_F(Primo, two_starts_end_in_one_shape)
{
    for (const SurfaceMesh& mesh : {shapes::bar(20, 5), triangulated(shapes::bar(20, 5))})
        calls::expect_starts_meet(bound(mesh, {}, shapes::ends(mesh, 2)), 2, 1000, 1e-7);
}

TEST_F(Primo, four_iterations_are_within_one_percent)
{
    for (const SurfaceMesh& mesh : {triangulated(shapes::bar(40, 10)), shapes::bar(40, 10)})
        for (const Poses& poses : {bend(90, 40), twist(135)}) {
            const Method primo = bound(mesh, {}, shapes::ends(mesh, 2));
            const Points limit = solve(primo, poses, {.max_iterations = 1000, .tolerance = 1e-12}).positions;
            const double moved = rms(limit, mesh.points());
            EXPECT_LT(rms(solve(primo, poses, {.max_iterations = 4, .tolerance = 0.0}).positions, limit),
                      0.01 * moved);
            EXPECT_LT(rms(solve(primo, poses).positions, limit), 0.01 * moved);
        }
}

TEST_F(Primo, higher_prisms_bend_less)
{
    // A strip hangs between two handles, one of which tilts: the higher the prisms, the farther along it the
    // strip keeps the tilt.
    const SurfaceMesh mesh = shapes::quad_grid(30, 4);
    double before = std::numeric_limits<double>::infinity();
    for (double height : {0.003, 0.01, 0.03, 0.1}) {
        const Method primo = bound(mesh, {.height = {height}}, shapes::ends(mesh, 1));
        const Solution s =
            solve(primo, {shapes::still(), shapes::turn({0, 1, 0}, 40, {29, 2, 0})}, {.max_iterations = 300});
        double most = 0.0; // the largest angle between neighbouring edges along the middle of the strip
        const auto row = [&](int x) -> Eigen::RowVector3d { return s.positions.row(2 * 31 + x); };
        for (int x = 1; x < 30; ++x) {
            const Eigen::RowVector3d a = row(x) - row(x - 1), b = row(x + 1) - row(x);
            most = std::max(most, std::atan2(a.cross(b).norm(), a.dot(b)));
        }
        EXPECT_LT(most, before);
        before = most;
    }
}

TEST_F(Primo, an_affine_pose_takes_its_handle_and_the_surface_along)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    const Method primo = bound(mesh, {}, shapes::ends(mesh, 2));
    const std::vector<int> moved = shapes::ends(mesh, 2)[1].vertices;
    for (const Vector3& scale : {Vector3(1, 2, 1.5), Vector3(0.5, 0.5, 0.5), Vector3(1, 1, -1)}) {
        const Pose pose = shapes::affine(scale.asDiagonal());
        const Solution s = solve(primo, {shapes::still(), pose}, {.max_iterations = 100});
        ASSERT_TRUE(s.positions.allFinite());
        for (int v : moved)
            EXPECT_LT((s.positions.row(v).transpose() - apply(pose, mesh.point(v))).norm(), 1e-12);
    }
    // Both ends twice as large: so is the bar near them, and no prism is against it.
    const Pose twice = shapes::affine(2 * Matrix3::Identity());
    const Points q = solve(primo, {twice, twice}).positions;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (mesh.point(v).x() == 3.0 || mesh.point(v).x() == 9.0) {
            EXPECT_GT(std::abs(q(v, 1) - q.col(1).mean()),
                      1.2 * std::abs(mesh.point(v).y() - mesh.points().col(1).mean()));
        }
}

TEST_F(Primo, a_painted_height_stiffens_its_region)
{
    const SurfaceMesh mesh = shapes::quad_grid(30, 4);
    std::vector<double> painted(mesh.vertex_count(), 0.005);
    for (int v : shapes::where(mesh, [](const Vector3& p) { return p.x() >= 10 && p.x() <= 20; }))
        painted[v] = 0.2;
    const auto bent = [&](const std::vector<double>& height) {
        const Points q = solve(bound(mesh, {.height = height}, shapes::ends(mesh, 1)),
                               {shapes::still(), shapes::turn({0, 1, 0}, 80, {29, 2, 0}, {-5, 0, 0})},
                               {.max_iterations = 400})
                             .positions;
        const Eigen::RowVector3d a = q.row(2 * 31 + 12) - q.row(2 * 31 + 11),
                                 b = q.row(2 * 31 + 19) - q.row(2 * 31 + 18);
        return std::atan2(a.cross(b).norm(), a.dot(b));
    };
    EXPECT_LT(bent(painted), 0.2 * bent({0.005}));
    // Black is raised to a thousandth of the largest value.
    painted[7] = 0.0;
    EXPECT_TRUE(
        solve(bound(mesh, {.height = painted}, shapes::ends(mesh, 1)), bend(60, 30)).positions.allFinite());
}

TEST_F(Primo, faces_of_many_corners_stay_stiff)
{
    // A drum: two polygons of 24 corners and a wall of quads.
    std::vector<Vector3> points;
    shapes::Polygons faces(2);
    for (int k = 0; k < 24; ++k)
        for (int z = 0; z < 4; ++z)
            points.emplace_back(std::cos(2 * shapes::pi * k / 24), std::sin(2 * shapes::pi * k / 24), z);
    for (int k = 0; k < 24; ++k) {
        faces[0].insert(faces[0].begin(), 4 * k);
        faces[1].push_back(4 * k + 3);
        for (int z = 0; z < 3; ++z)
            faces.push_back({4 * k + z, 4 * ((k + 1) % 24) + z, 4 * ((k + 1) % 24) + z + 1, 4 * k + z + 1});
    }
    const SurfaceMesh drum = shapes::mesh(points, faces);
    const Method primo = bound(drum, {}, {{faces[0], {}}, {{3}, {}}}); // the bottom, and a vertex of the top
    const Solution s = solve(primo, {shapes::still(), shapes::shift(0.5, 0, 0.5)}, {.max_iterations = 200});
    // The lid is nearly as it was: its vertices are means of where it and two faces of the wall take them.
    for (int k = 1; k < 24; ++k)
        EXPECT_NEAR((s.positions.row(4 * k + 3) - s.positions.row(4 * ((k + 12) % 24) + 3)).norm(), 2.0, 0.2);
}

} // namespace sinew::test_primo
