// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/subspace_laplacian.h"

#include "tests/native/methods/surface/contract.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <memory>

namespace sinew::test_subspace_laplacian {

namespace {

using Options = SubspaceLaplacianOptions;

auto maker(const Options& options)
{
    return [options](const SurfaceMesh& mesh) { return std::make_shared<SubspaceLaplacian>(mesh, options); };
}

/// The end at `along` goes to the end of a circular arc.
Poses bend(double degrees, double along = 12, double depth = 2)
{
    const double angle = degrees * shapes::pi / 180, radius = (along - 2 * depth) / angle;
    const Vector3 end(depth + radius * std::sin(angle), radius * (1 - std::cos(angle)), 0);
    const Vector3 from(along - depth, 0, 0);
    return {shapes::still(), shapes::turn({0, 0, 1}, degrees, from, end - from)};
}

/// 6 times the volume, term by term.
double volume(const SurfaceMesh& mesh, const Points& points)
{
    double six = 0.0;
    const auto at = [&](int v) { return Vector3((points.row(v) - points.row(0)).transpose()); };
    for (const Triangle& t : mesh.triangles())
        six += at(t[0]).dot(at(t[1]).cross(at(t[2])));
    return six / 6;
}

SurfaceTraits traits()
{
    // Beyond that, a body as stout as this one has two ways to bulge, and the better one changes.
    const auto drag = [](double s) {
        const double t = 0.5 - 0.5 * std::cos(2 * shapes::pi * s);
        return Poses{shapes::still(), shapes::turn({0.2, 1, 0.5}, 70 * t, {18, 0, 0},
                                                   {-4 * t, 3 * t, 2 * std::sin(2 * shapes::pi * s)})};
    };
    return {.name = "SubspaceLaplacian",
            .variants = {{"default", maker({}), 1, true},
                         {"volume free", maker({.keep_volume = false}), 1, true},
                         {"without a cage", maker({.cage_faces = 2000, .clusters = 20}), 1, true}},
            .mesh = shapes::bar(12, 3),
            .large = shapes::bar(20, 5),
            .depth = 2,
            .bent = bend(60),
            .drag = drag,
            .drag_steps = 30,
            .follow = 1.5, // the surface between two handles follows the faster one
            .slack = 0.05,
            .rest = 1e-11,     // rounding of a dense solve of condition 1e8
            .incoming = 1e-10, // likewise
            .noise = 0.2,
            .translation = 1e-9,
            .rigid = 1e-11,
            .held = 1e-12,
            .alone = 1e-12,
            .similar = 0.5, // the automatic cage follows the axes, so that another one is made
            .scaled = 0.05, // it may differ where its decisions are close
            .apart = 1e-6,  // the same sums in another order
            .messy = 30.0,
            .folded = 1e-6,
            .soft = 0.2, // the cage cannot meet handles exactly; only held vertices are put where they belong
            .all_soft = 1.5,
            .updates = "bending",
            .updated = maker({.bending = 0.01}),
            .other = maker({.cage_faces = 100})};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(SubspaceLaplacian, SurfaceContract, testing::Values(traits()));

TEST(SubspaceLaplacian, keeps_the_volume_of_the_surface)
{
    const SurfaceMesh mesh = shapes::bar(20, 5);
    const std::vector<Handle> handles = shapes::ends(mesh, 2);
    const double before = volume(mesh, mesh.points());
    for (const Poses& poses : {bend(120, 20), Poses{shapes::still(), shapes::turn({1, 0, 0}, 135)}}) {
        SubspaceLaplacian keeping(mesh), free(mesh, {.keep_volume = false});
        keeping.set_handles(handles);
        free.set_handles(handles);
        Points kept, lost;
        keeping.solve({poses}, kept);
        free.solve({poses}, lost);
        EXPECT_LT(std::abs(volume(mesh, kept) / before - 1), 1e-12);
        EXPECT_GT(std::abs(volume(mesh, lost) / before - 1), 0.02);
    }
}

TEST(SubspaceLaplacian, keeps_the_volume_of_the_shape_that_enters)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    SubspaceLaplacian method(mesh);
    method.set_handles(shapes::ends(mesh, 2));
    Points incoming = mesh.points();
    incoming.col(1) *= 1.4;
    Points q;
    method.solve({.poses = bend(60), .incoming = view(incoming)}, q);
    EXPECT_LT(std::abs(volume(mesh, q) / volume(mesh, incoming) - 1), 1e-12);
}

TEST(SubspaceLaplacian, names_vertices_outside_a_given_cage)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    Points box = shapes::cube().points();
    box = (box.rowwise() - box.colwise().mean()).eval();
    box = (box * 40.0).eval();
    EXPECT_NO_THROW(
        SubspaceLaplacian(mesh, {}, shapes::moved(shapes::cube(), box)).set_handles(shapes::ends(mesh, 2)));
    box.col(0) *= 0.3; // from -6 to 6, while the bar reaches 12
    SubspaceLaplacian method(mesh, {}, shapes::moved(shapes::cube(), box));
    try {
        method.set_handles(shapes::ends(mesh, 2));
        FAIL() << "nothing was refused";
    } catch (const InvalidConstraint& refusal) {
        EXPECT_EQ(refusal.element_kind(), Error::Element::vertex);
        EXPECT_EQ(refusal.elements(), shapes::where(mesh, [](const Vector3& p) { return p.x() > 6; }));
    }
}

TEST(SubspaceLaplacian, refuses_options_out_of_range)
{
    const SurfaceMesh mesh = shapes::octahedron();
    EXPECT_THROW(SubspaceLaplacian(mesh, {.cage_faces = 11}), InvalidOption);
    EXPECT_THROW(SubspaceLaplacian(mesh, {.cage_faces = 2001}), InvalidOption);
    EXPECT_THROW(SubspaceLaplacian(mesh, {.clusters = 0}), InvalidOption);
    EXPECT_THROW(SubspaceLaplacian(mesh, {.bending = -1.0}), InvalidOption);
    EXPECT_THROW(SubspaceLaplacian(mesh, {.max_iterations = 0}), InvalidOption);
    EXPECT_THROW(SubspaceLaplacian(mesh, {}, shapes::grid(2, 2)), InvalidMesh);
}

} // namespace sinew::test_subspace_laplacian
