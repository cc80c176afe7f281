// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/sketch/silhouette_sketch.h"

#include "native/operators/laplacian.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_silhouette_sketch {

namespace {

/// Points on the edges of a hill that a line x = 3.4 crosses, and the vertices that stay.
struct Hill
{
    SurfaceMesh mesh = shapes::hill(7, 8);
    std::vector<LinePoint> line;
    std::vector<int> held;

    Hill()
    {
        for (const auto& [a, b] : mesh.edges()) {
            const double xa = mesh.point(a).x(), xb = mesh.point(b).x();
            if ((xa < 3.4) != (xb < 3.4) && std::abs(mesh.point(a).y() - mesh.point(b).y()) < 0.5)
                line.push_back({a, b, (3.4 - xa) / (xb - xa)});
        }
        held = shapes::where(mesh, [](const Vector3& p) { return p.x() < 0.5 || p.x() > 6.5; });
    }

    Points on(const Points& positions) const
    {
        Points found(static_cast<Eigen::Index>(line.size()), 3);
        for (std::size_t k = 0; k < line.size(); ++k)
            found.row(static_cast<Eigen::Index>(k)) = line[k].on(view(positions)).transpose();
        return found;
    }

    Points solved(const Points& targets, const SilhouetteSketchOptions& options = {}) const
    {
        Points positions;
        SilhouetteSketch(mesh, line, held, options).solve(view(targets), positions);
        return positions;
    }

    /// The line lifted by a hump.
    Points lifted() const
    {
        Points targets = on(mesh.points());
        for (int k = 0; k < targets.rows(); ++k)
            targets(k, 2) += 0.8 * std::sin(0.4 * targets(k, 1)) + 0.1;
        return targets;
    }
};

} // namespace

TEST(SilhouetteSketch, a_line_that_stays_changes_nothing)
{
    const Hill hill;
    for (const Discretization kind :
         {Discretization::uniform, Discretization::cotan, Discretization::cotan_voronoi})
        EXPECT_LT(shapes::distance(hill.solved(hill.on(hill.mesh.points()), {.laplacian = kind}),
                                   hill.mesh.points()),
                  1e-11); // rotations are fitted to edges that have not turned
}

TEST(SilhouetteSketch, the_line_meets_its_targets_as_its_weight_says)
{
    const Hill hill;
    const Points targets = hill.lifted();
    double before = 1.0;
    for (const double weight : {0.5, 0.99, 0.9999}) {
        const double off = shapes::distance(hill.on(hill.solved(targets, {.weight = weight})), targets);
        EXPECT_LT(off, before / 4);
        before = off;
    }
    EXPECT_LT(before, 1e-3);
}

TEST(SilhouetteSketch, without_held_vertices_follows_a_translation_exactly_and_a_turn_by_refits)
{
    Hill hill;
    hill.held.clear();
    for (int v = 0; v < hill.mesh.vertex_count(); v += 5) // a line alone would leave a turn about it open
        hill.line.push_back({v, v, 0.0});
    const Pose shift = shapes::shift(1, -2, 3);
    EXPECT_LT(shapes::distance(hill.solved(shapes::transformed(hill.on(hill.mesh.points()), shift)),
                               shapes::transformed(hill.mesh.points(), shift)),
              1e-9);
    const Pose turn = shapes::turn({1, 2, 3}, 50);
    const Points goal = shapes::transformed(hill.mesh.points(), turn);
    double before = 1e9;
    for (const int refits : {0, 4, 64}) {
        const double off = shapes::distance(
            hill.solved(shapes::transformed(hill.on(hill.mesh.points()), turn), {.refits = refits}), goal);
        EXPECT_LT(off, before / 2);
        before = off;
    }
}

TEST(SilhouetteSketch, leaves_held_vertices_and_other_parts_as_they_are)
{
    Hill hill;
    hill.mesh = shapes::joined(hill.mesh, shapes::sphere(1), {20, 0, 0});
    const Points found = hill.solved(hill.lifted());
    std::vector<int> stay = hill.held;
    for (int v = 72; v < hill.mesh.vertex_count(); ++v)
        stay.push_back(v);
    for (int v : stay)
        EXPECT_EQ(found.row(v), hill.mesh.points().row(v));
    EXPECT_GT(shapes::distance(found, hill.mesh.points()), 0.5);
}

TEST(SilhouetteSketch, sharpness_bends_the_surface_at_the_line)
{
    const Hill hill;
    const Points targets = hill.on(hill.mesh.points());
    const MatrixX L = laplacian_matrix(hill.mesh, Discretization::cotan_voronoi);
    const auto bend = [&](double sharpness) { // of both rows of vertices beside the line
        const MatrixX delta = L * hill.solved(targets, {.sharpness = sharpness});
        double sum = 0.0;
        for (const LinePoint& point : hill.line)
            sum += delta.row(point.a).norm() + delta.row(point.b).norm();
        return sum;
    };
    EXPECT_GT(bend(1), 1.2 * bend(0));
    EXPECT_GT(bend(3), 1.2 * bend(1));
}

TEST(SilhouetteSketch, ten_strokes_take_one_factorisation_and_are_the_same_again)
{
    const Hill hill;
    const SilhouetteSketch sketch(hill.mesh, hill.line, hill.held);
    const Points targets = hill.lifted();
    Points first, again;
    for (int k = 0; k < 10; ++k) {
        const Points moved = (1 + 0.1 * k) * targets;
        sketch.solve(view(moved), k == 0 ? first : again);
    }
    sketch.solve(view(targets), again);
    EXPECT_EQ(first, again);
    EXPECT_EQ(sketch.factorizations(), 1);
}

TEST(SilhouetteSketch, copes_with_a_messy_mesh)
{
    const SurfaceMesh mesh = shapes::messy();
    const std::vector<int> held = shapes::where(mesh, [](const Vector3& p) { return p.x() < 1; });
    std::vector<LinePoint> line;
    for (int v : shapes::where(mesh, [](const Vector3& p) { return p.x() > 3; }))
        line.push_back({v, v, 0.0});
    Points targets(static_cast<Eigen::Index>(line.size()), 3), found;
    for (std::size_t k = 0; k < line.size(); ++k)
        targets.row(static_cast<Eigen::Index>(k)) =
            mesh.points().row(line[k].a) + Eigen::RowVector3d(0, 0, 1);
    SilhouetteSketch(mesh, line, held).solve(view(targets), found);
    EXPECT_TRUE(found.allFinite());
    EXPECT_LT(shapes::distance(found, mesh.points()), 3 * shapes::size(mesh.points()));
}

} // namespace sinew::test_silhouette_sketch
