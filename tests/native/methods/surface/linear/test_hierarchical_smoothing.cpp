// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/hierarchical_smoothing.h"

#include "native/methods/surface/linear/thin_shell.h"
#include "tests/native/allocations.h"
#include "tests/native/dense.h"
#include "tests/native/methods/surface/contract.h"
#include "tests/native/methods/surface/linear/dense_operators.h"
#include "tests/native/methods/surface/linear/study_tube.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cmath>
#include <map>

namespace sinew::test_hierarchical_smoothing {

namespace {

const Poses bent{shapes::still(), shapes::turn({0, 1, 0}, 40, {6, 0, 0}, {-1, 0.5, 2})};

auto maker(int levels, int relaxations)
{
    return [=](const SurfaceMesh& mesh) {
        return std::make_shared<HierarchicalSmoothing>(mesh,
                                                       HierarchicalSmoothingOptions{levels, relaxations});
    };
}

Points solved(const SurfaceMesh& mesh, const std::vector<Handle>& handles, const SolveRequest& request,
              const HierarchicalSmoothingOptions& options = {}, SolveReport* report = nullptr)
{
    HierarchicalSmoothing smoothing(mesh, options);
    smoothing.set_handles(handles);
    Points positions;
    const SolveReport found = smoothing.solve(request, positions);
    if (report)
        *report = found;
    return positions;
}

SurfaceTraits traits()
{
    const auto drag = [](double t) {
        const double angle = 2 * shapes::pi * t;
        return Poses{shapes::still(), shapes::turn({0, 1, 0}, 60 * std::sin(angle), {9, 4, 0},
                                                   {2 * std::cos(angle) - 2, std::sin(angle), 0})};
    };
    return {
        .name = "HierarchicalSmoothing",
        .variants = {{"hierarchy", maker(64, 4)}, {"one level", maker(0, 4)}, {"unrelaxed", maker(64, 0)}},
        .mesh = shapes::hill(16, 10),
        .large = shapes::hill(20, 18),
        .depth = 1.5,
        .bent = bent,
        .drag = drag,
        .drag_steps = 48,
        .follow = 2.0, // where the surface bends outwards, it goes farther than the handle
        .slack = 0.0,
        .rest = 1e-13, // each level takes its details apart and puts them together
        .incoming = 1e-13,
        .translation = 1e-8, // a single vertex leaves turns to the Laplacian of 1e-8
        .rigid = 1e-11, // rounding errors, carried through all levels
        .similar = 1e-9,
        .scaled = 1e-9,
        .updates = "levels",
        .updated = maker(2, 4)};
}

/// The sum of squared second differences by planes through unfolded triangles, as a dense matrix, and the
/// share of the Laplacian.
MatrixX dense_energy(const SurfaceMesh& mesh)
{
    MatrixX H = 1e-8 * dense_laplacian(mesh, Discretization::cotan);
    std::map<std::pair<int, int>, std::vector<int>> apexes;
    for (const auto& [a, b, c] : mesh.triangles())
        for (const auto& [from, to, apex] : {std::array{a, b, c}, {b, c, a}, {c, a, b}})
            apexes[std::minmax(from, to)].push_back(apex);
    for (const auto& [edge, pair] : apexes) {
        if (pair.size() != 2)
            continue;
        const int vertices[4] = {edge.first, edge.second, pair[0], pair[1]};
        // The edge along x, one apex above and one below it, at their distances.
        const Vector3 j = mesh.point(vertices[0]), k = mesh.point(vertices[1]);
        const double length = (k - j).norm();
        Eigen::Vector2d places[4] = {{0, 0}, {length, 0}, {}, {}};
        for (int side : {0, 1}) {
            const Vector3 apex = mesh.point(vertices[2 + side]) - j;
            const double along = apex.dot(k - j) / length;
            places[2 + side] = {along, (side ? -1 : 1) * std::sqrt(apex.squaredNorm() - along * along)};
        }
        // The slopes across the edge on both triangles, for a function that is 1 at one vertex.
        VectorX jump = VectorX::Zero(4);
        for (int side : {0, 1}) {
            Matrix3 plane; // f = p + q x + r y at the corners
            const int corners[3] = {0, 1, 2 + side};
            for (int c = 0; c < 3; ++c)
                plane.row(c) << 1.0, places[corners[c]].x(), places[corners[c]].y();
            const Matrix3 inverse = plane.inverse();
            for (int c = 0; c < 3; ++c)
                jump[corners[c]] += (side ? -1 : 1) * inverse(2, c);
        }
        jump *= std::sqrt(-places[2].y() * places[3].y());
        for (int a = 0; a < 4; ++a)
            for (int b = 0; b < 4; ++b)
                H(vertices[a], vertices[b]) += jump[a] * jump[b];
    }
    return H;
}

} // namespace

INSTANTIATE_TEST_SUITE_P(HierarchicalSmoothing, SurfaceContract, testing::Values(traits()));

TEST(HierarchicalSmoothing, without_levels_solves_as_dense_second_differences_do)
{
    for (const SurfaceMesh& mesh : {shapes::hill(8, 8), shapes::sphere(2)}) {
        const int n = mesh.vertex_count();
        const std::vector<Handle> handles = shapes::ends(mesh, shapes::size(mesh.points()) / 8);
        const Vector3 move(1, -2, 3);
        // Translations have T = 1 and a mean shift, which all second differences leave out.
        const MatrixX H = dense_energy(mesh);
        MatrixX d = MatrixX::Zero(n, 3);
        std::vector<bool> held(n, false);
        for (int h : {0, 1})
            for (int v : handles[h].vertices) {
                held[v] = true;
                d.row(v) = h * move.transpose();
            }
        std::vector<int> free;
        for (int v = 0; v < n; ++v)
            if (!held[v])
                free.push_back(v);
        d = dense::solution(H, MatrixX::Zero(n, 3), d, free);
        SolveReport report;
        const Points q = solved(mesh, handles, {.poses = {shapes::still(), shapes::shift(1, -2, 3)}},
                                {.levels = 0}, &report);
        EXPECT_LT(shapes::distance(q, mesh.points() + d), 1e-10); // condition numbers are below 1e5
        EXPECT_NEAR(report.energy, 0.5 * (d.transpose() * H * d).trace(), 1e-10);
        EXPECT_LT(report.residual, 1e-11);
    }
}

TEST(HierarchicalSmoothing, many_sweeps_come_to_the_smoothest_displacement)
{
    // Details of a plane are zero, so that each level goes on from the one before, to the same minimum.
    // More than a third of the 121 free vertices may go until 64 are left. So the first level takes all that
    // are no neighbours, and each of the others is near one of them.
    const SurfaceMesh mesh = shapes::grid(16, 10, 1.0, 0.2);
    const std::vector<Handle> handles = shapes::ends(mesh, 2.5);
    const Poses lift{shapes::still(), shapes::shift(0, 0, 3)};
    const Points smoothest = solved(mesh, handles, {.poses = lift}, {.levels = 0});
    double before = 1.0;
    for (int sweeps : {0, 4, 64, 20000}) {
        const double gap =
            shapes::distance(solved(mesh, handles, {.poses = lift}, {.relaxations = sweeps}), smoothest);
        EXPECT_LT(gap, before) << sweeps;
        before = gap;
    }
    EXPECT_LT(before, 5e-3)
        << "half a pixel of a lift drawn 300 pixels high; each level relaxes only what is near its "
           "new vertices";
}

TEST(HierarchicalSmoothing, planes_are_exact)
{
    // Whatever is linear on a plane is relaxed into itself, on all levels: the surface between handles that
    // agree with one linear map is that map, although no pose is alike.
    const SurfaceMesh mesh = shapes::grid(24, 16, 1.0, 0.25);
    const std::vector<Handle> handles = shapes::ends(mesh, 2.5);
    Matrix3 shear = Matrix3::Identity(), other = shear;
    shear(2, 0) = 0.4;
    shear(2, 1) = -0.3;
    shear(0, 0) = 1.2;
    other = shear;
    other(0, 2) = 0.7; // nothing on the plane is moved by it
    const Points q = solved(mesh, handles,
                            {.poses = {shapes::affine(shear, {1, 2, 3}), shapes::affine(other, {1, 2, 3})}});
    EXPECT_LT(shapes::distance(q, shapes::transformed(mesh.points(), shapes::affine(shear, {1, 2, 3}))), 1e-6)
        << "at free borders, the Laplacian of 1e-8 pulls a little";
}

TEST(HierarchicalSmoothing, details_are_reconstructed_exactly_on_all_levels)
{
    const SurfaceMesh mesh = shapes::sphere(4); // 1026 vertices
    HierarchicalSmoothing smoothing(mesh);
    smoothing.set_handles(shapes::ends(mesh, 0.3));
    EXPECT_GT(smoothing.level_count(), 6);
    Points incoming = mesh.points();
    shapes::Random random(4);
    for (int v = 0; v < incoming.rows(); ++v)
        incoming.row(v) += 0.05 * random.vector().transpose();
    for (const Points& y : {mesh.points(), incoming}) {
        Points q;
        smoothing.solve({.poses = Poses(2, shapes::still()), .incoming = view(y)}, q);
        EXPECT_LT(shapes::distance(q, y), 1e-14);
        const Pose pose = shapes::turn({1, 2, -0.5}, 170, {3, 7, 1}, {3, -2, 1});
        smoothing.solve({.poses = {pose, pose}, .incoming = view(y)}, q);
        EXPECT_LT(shapes::distance(q, shapes::transformed(y, pose)), 1e-13);
    }
}

TEST(HierarchicalSmoothing, details_turn_with_the_coarser_shape)
{
    // A plate with a fine pattern, whose end is turned up: single vertices that stand 0.05 above their
    // neighbours stand so along the normals of the turned plate, too. The bend of the plate shows in the same
    // way between vertices that stand alike, at three times the distance, which is nine times as much.
    const SurfaceMesh plain = shapes::grid(48, 16, 0.25);
    Points p = plain.points();
    for (int v = 0; v < p.rows(); ++v)
        p(v, 2) = (v % 3 == 0) * 0.05;
    const SurfaceMesh mesh = shapes::moved(plain, p);
    const Points q = solved(mesh, shapes::ends(mesh, 1.0),
                            {.poses = {shapes::still(), shapes::turn({0, 1, 0}, -80, {9, 0, 0})}});
    double worst = 0.0, steepest = 0.0;
    for (int v = 0; v < p.rows(); ++v) {
        const int column = v % 49, row = v / 49;
        if (p(v, 2) == 0 || column < 6 || column > 42 || row == 0 || row == 16)
            continue;
        const auto above = [&](int step) -> Vector3 {
            return (q.row(v) - 0.5 * (q.row(v + step) + q.row(v - step))).transpose();
        };
        const Vector3 along = (q.row(v + 1) - q.row(v - 1)).transpose(),
                      across = (q.row(v + 49) - q.row(v - 49)).transpose();
        const Vector3 normal = along.cross(across).normalized();
        worst = std::max(worst, (above(1) - above(3) / 9 - 0.05 * normal).norm());
        steepest = std::max(steepest, std::acos(normal.z()));
    }
    EXPECT_GT(steepest, 1.0);
    EXPECT_LT(worst, 0.01) << "a fifth; details that keep their directions are wrong by 0.05 here";
}

TEST(HierarchicalSmoothing, bends_a_tube_by_120_degrees)
{
    const SurfaceMesh mesh = study_tube();
    const Poses poses{shapes::still(), study_bend()};
    const std::vector<Handle> handles = shapes::ends(mesh, study_depth);
    ThinShell shell(mesh);
    shell.set_handles(handles);
    Points unturned;
    shell.solve({poses}, unturned);
    const double strain = rms_edge_ratio(mesh, solved(mesh, handles, {.poses = poses}));
    EXPECT_LT(strain, rms_edge_ratio(mesh, unturned)) << "the thin shell turns nothing";
    EXPECT_GT(strain, 0.058) << "the isometric bend of the axis";
}

TEST(HierarchicalSmoothing, handles_of_other_parts_do_not_count)
{
    const SurfaceMesh mesh = shapes::hill(8, 8), both = shapes::joined(mesh, mesh, {0, 20, 0});
    const int n = mesh.vertex_count();
    std::vector<Handle> handles = shapes::ends(mesh, 1.5), more = handles;
    more.push_back({{n + 3, n + 40}, {}});
    const Poses poses{bent[0], bent[1], shapes::turn({1, 0, 1}, 140)};
    // With no levels: the number of vertices that are enough is one for all parts.
    EXPECT_LT(shapes::distance(solved(both, more, {.poses = poses}, {.levels = 0}).topRows(n),
                               solved(mesh, handles, {.poses = bent}, {.levels = 0})),
              1e-9);
}

TEST(HierarchicalSmoothing, refuses_numbers_below_zero)
{
    const SurfaceMesh mesh = shapes::hill(4, 4);
    EXPECT_THROW(HierarchicalSmoothing(mesh, {.levels = -1}), InvalidOption);
    EXPECT_THROW(HierarchicalSmoothing(mesh, {.relaxations = -1}), InvalidOption);
}

TEST(HierarchicalSmoothing, a_hierarchy_above_the_memory_limit_is_refused)
{
    const SurfaceMesh mesh = shapes::hill(40, 30);
    HierarchicalSmoothing smoothing(mesh);
    smoothing.set_handles(shapes::ends(mesh, 1.5));
    Points before, after;
    smoothing.solve({bent}, before);
    const MemoryLimit limit(100'000);
    EXPECT_THROW(smoothing.set_handles(shapes::ends(mesh, 2.5)), OutOfMemory);
    smoothing.solve({bent}, after);
    EXPECT_EQ(after, before);
}

TEST(HierarchicalSmoothing, solves_after_the_first_allocate_nothing_in_proportion_to_the_mesh)
{
    if (!allocations::counted())
        GTEST_SKIP() << "nobody counts here";
    const SurfaceMesh mesh = shapes::hill(60, 60);
    HierarchicalSmoothing smoothing(mesh);
    smoothing.set_handles(shapes::ends(mesh, 1.5));
    Points positions;
    const allocations::Count count(sizeof(double) * mesh.vertex_count());
    smoothing.solve({bent, view(mesh.points())}, positions);
    const int first = count.so_far();
    EXPECT_GT(first, 0);
    for (int k = 0; k < 3; ++k)
        smoothing.solve({bent, view(mesh.points())}, positions);
    EXPECT_EQ(count.so_far(), first);
}

} // namespace sinew::test_hierarchical_smoothing
