// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/pyramid_coordinates.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <memory>

namespace sinew::test_pyramid_coordinates {

namespace {

using calls::bend, calls::twist;

PyramidCoordinatesOptions toward(const SurfaceMesh& target)
{
    return {.target_shape = std::make_shared<const SurfaceMesh>(target)};
}

/// A bar that is thick in the middle and bent by 60 degrees.
SurfaceMesh changed_bar(const SurfaceMesh& bar)
{
    Points points = bar.points();
    const double radius = 12 / (60 * shapes::pi / 180);
    for (int v = 0; v < points.rows(); ++v) {
        const double x = points(v, 0), thick = 1 + 0.6 * std::sin(x / 12 * shapes::pi);
        const double angle = x / radius, y = points(v, 1) * thick, z = points(v, 2) * thick;
        points.row(v) << (radius - y) * std::sin(angle), radius - (radius - y) * std::cos(angle), z;
    }
    return shapes::moved(bar, points);
}

class PyramidCoordinates : public SurfaceFixture<sinew::PyramidCoordinates, PyramidCoordinatesOptions>
{
public:
    static SurfaceTraits traits()
    {
        // One alpha serves the cascade on the whole mesh. Beyond 55 degrees the hollow bar kinks like a tube,
        // at once.
        SurfaceTraits made =
            nonlinear("PyramidCoordinates", {{"default", maker(), 1, false},
                                             {"similarity", maker({.similarity = true}), 1, false},
                                             {"side 0.5", maker({.side = 0.5}), 1, false}});
        made.drag = [](double s) {
            const double t = 0.5 - 0.5 * std::cos(2 * shapes::pi * s);
            return Poses{shapes::still(), shapes::turn({0.2, 1, 0.5}, 45 * t, {18, 0, 0},
                                                       {-2 * t, 2 * t, std::sin(2 * shapes::pi * s)})};
        };
        made.iterative = true;
        made.degenerate_faces = 0;
        made.settles = 2000;
        made.settling = 2;
        made.other = maker({.side = 0.2});
        return made;
    }
};

} // namespace

INSTANTIATE_TEST_SUITE_P(PyramidCoordinates, SurfaceContract, testing::Values(PyramidCoordinates::traits()));

TEST_F(PyramidCoordinates, grows_with_its_handles_where_rings_may_grow)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    const Method rigid = bound(mesh, {}, shapes::ends(mesh, 2));
    const Method similar = bound(mesh, {.similarity = true}, shapes::ends(mesh, 2));
    for (const double scale : {0.6, 1.7}) {
        const Pose pose = shapes::affine(scale * shapes::rotation({1, 2, -0.5}, 100), {3, 1, 2});
        const Points wanted = shapes::transformed(mesh.points(), pose);
        EXPECT_LT(shapes::distance(solve(similar, {pose, pose}).positions, wanted), 1e-11 * 12) << scale;
        EXPECT_GT(solve(rigid, {pose, pose}).report.energy, 0.01) << scale;
    }
    // Beyond the range the rings are strained, but nothing breaks.
    const Pose huge = shapes::affine(4 * Matrix3::Identity());
    const Solution far = solve(similar, {huge, huge});
    EXPECT_TRUE(far.positions.allFinite());
    EXPECT_GT(far.report.energy, 0.01);
    // One end twice as large as the other: rings between grow evenly, so less is strained.
    const Poses one{shapes::still(), shapes::affine(1.8 * Matrix3::Identity(), {-8, 0, 0})};
    EXPECT_LT(solve(similar, one).report.energy, 0.5 * solve(rigid, one).report.energy);
}

TEST_F(PyramidCoordinates, a_few_iterations_reach_the_limit_on_coarse_and_fine_meshes)
{
    // Creases without a bound and heights that weigh alike on all meshes need 30 to 50 on the finer one.
    for (const int across : {6, 24}) {
        const SurfaceMesh mesh = shapes::bar(4 * across, across);
        Points rest = mesh.points();
        const std::vector<Handle> handles = shapes::ends(mesh, 0.2 * across);
        const Method method = bound(mesh, {}, handles);
        for (const Poses& poses : {bend(90, 4 * across, 0.2 * across), twist(135)}) {
            const Points limit = solve(method, poses, {.max_iterations = 1000, .tolerance = 1e-12}).positions;
            const Points reached = solve(method, poses, {.max_iterations = 15, .tolerance = 0.0}).positions;
            EXPECT_LT((reached - limit).norm(), 0.01 * (limit - rest).norm()) << across;
        }
    }
}

TEST_F(PyramidCoordinates, bends_alike_on_coarse_and_fine_meshes)
{
    std::vector<double> middles;
    for (const int across : {4, 8, 16}) {
        const SurfaceMesh mesh =
            shapes::moved(shapes::bar(4 * across, across), shapes::bar(4 * across, across).points() / across);
        const Method method = bound(mesh, {}, shapes::ends(mesh, 0.25));
        const Points shape = solve(method, {shapes::still(), shapes::shift(-1, 1.5, 0)},
                                   {.max_iterations = 400, .tolerance = 1e-10})
                                 .positions;
        double sum = 0.0;
        int count = 0;
        for (int v = 0; v < shape.rows(); ++v)
            if (std::abs(mesh.point(v).x() - 2) < 1e-9) {
                sum += shape(v, 1);
                ++count;
            }
        middles.push_back(sum / count);
    }
    EXPECT_LT(std::abs(middles[2] - middles[1]), 0.6 * std::abs(middles[1] - middles[0]) + 1e-3);
    EXPECT_NEAR(middles[2], middles[1], 0.03); // of a bar of 4 x 1 x 1
}

TEST_F(PyramidCoordinates, names_the_vertices_whose_ring_overlaps)
{
    // A vertex pulled far out of its ring, which the projection of some rings beside it shows outside.
    SurfaceMesh plane = shapes::grid(6, 6);
    Points points = plane.points();
    const int middle = 3 * 7 + 3;
    points.row(middle) += Eigen::RowVector3d(2.5, 0, 0.1);
    const SurfaceMesh folded = shapes::moved(plane, points);
    Method method(folded);
    const std::vector<Handle> handles{
        {shapes::where(folded, [](const Vector3& p) { return p.x() < 0.5; }), {}}};
    EXPECT_TRUE(method.folded_rings().empty());
    method.set_handles(handles);
    EXPECT_TRUE(std::ranges::binary_search(method.folded_rings(), middle));
    EXPECT_TRUE(bound(plane, {}, handles).folded_rings().empty());
    Method to_folded(plane, toward(folded));
    to_folded.set_handles(handles);
    EXPECT_EQ(to_folded.folded_rings(), method.folded_rings());
    EXPECT_LT(shapes::distance(solve(method, {shapes::still()}).positions, points), 1e-12);
    const Pose pose = shapes::turn({1, 1, 0}, 80);
    EXPECT_LT(shapes::distance(solve(method, {pose}).positions, shapes::transformed(points, pose)), 1e-11);
}

TEST_F(PyramidCoordinates, goes_evenly_from_one_shape_to_the_other_and_takes_it_along)
{
    const SurfaceMesh mesh = shapes::bar(12, 3), target = changed_bar(mesh);
    const Method method = bound(mesh, toward(target), shapes::ends(mesh, 2));
    const auto at = [&](double share, const Pose& pose, SolveRequest request = {}) {
        request.extra = Morph{share};
        return solve(method, {pose, pose}, request).positions;
    };
    const Pose still = shapes::still(), pose = shapes::turn({1, 2, -0.5}, 170, {3, 7, 1}, {30, -20, 10});
    const double way = shapes::distance(mesh.points(), target.points());
    Points last = mesh.points(), half;
    for (int k = 0; k <= 20; ++k) {
        const Points now = at(k / 20.0, still);
        EXPECT_LT(shapes::distance(now, last), k ? 0.1 * way + 0.05 : 1e-11);
        last = now;
        if (k == 10)
            half = now;
    }
    EXPECT_LT(shapes::distance(last, target.points()), 1e-10);
    const Points incoming = shapes::transformed(mesh.points(), pose),
                 there = shapes::transformed(target.points(), pose);
    EXPECT_LT(shapes::distance(at(1.0, pose), there), 1e-10);
    EXPECT_LT(shapes::distance(at(1.0, still, {.incoming = view(incoming)}), there), 1e-10);
    EXPECT_LT(shapes::distance(at(0.0, still, {.incoming = view(incoming)}), incoming), 1e-11);
    EXPECT_LT(shapes::distance(at(0.5, pose), shapes::transformed(half, pose)), 0.01); // where it stops
}

TEST_F(PyramidCoordinates, morphs_parts_without_a_handle)
{
    const SurfaceMesh one = shapes::bar(6, 2), both = shapes::joined(one, shapes::octahedron(), {0, 9, 0});
    Points points = both.points();
    points.bottomRows(6) = (2 * points.bottomRows(6)).rowwise() + Eigen::RowVector3d(0, 0, 3);
    const Method method = bound(both, toward(shapes::moved(both, points)), shapes::ends(one, 1));
    for (const auto& [share, tolerance] : {std::pair(0.0, 1e-15), {0.5, 1e-9}, {1.0, 1e-10}}) {
        const Points expected = share * points + (1 - share) * both.points();
        const Points found = solve(method, Poses(2, shapes::still()), {.extra = Morph{share}}).positions;
        EXPECT_LT(shapes::distance(found.bottomRows(6), expected.bottomRows(6)), tolerance) << share;
    }
}

} // namespace sinew::test_pyramid_coordinates
