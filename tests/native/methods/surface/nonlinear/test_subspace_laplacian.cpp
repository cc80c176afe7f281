// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/subspace_laplacian.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_subspace_laplacian {

namespace {

using calls::bend;

/// 6 times the volume, term by term.
double volume(const SurfaceMesh& mesh, const Points& points)
{
    double six = 0.0;
    const auto at = [&](int v) { return Vector3((points.row(v) - points.row(0)).transpose()); };
    for (const Triangle& t : mesh.triangles())
        six += at(t[0]).dot(at(t[1]).cross(at(t[2])));
    return six / 6;
}

class SubspaceLaplacian : public SurfaceFixture<sinew::SubspaceLaplacian, SubspaceLaplacianOptions>
{
public:
    static SurfaceTraits traits()
    {
        // Turned by more, a body as stout as this one has two ways to bulge, and the better one changes.
        SurfaceTraits made =
            nonlinear("SubspaceLaplacian",
                      {{"default", maker(), 1, true},
                       {"volume free", maker({.keep_volume = false}), 1, true},
                       {"without a cage", maker({.cage_faces = 2000, .clusters = 20}), 1, true}},
                      70);
        made.slack = 0.05;
        made.rest = 1e-11; // rounding of a dense solve of condition 1e8
        made.incoming = 1e-10; // likewise
        made.held = made.alone = 1e-12;
        made.similar = 0.5; // the automatic cage follows the axes, so that another one is made
        made.apart = made.folded = 1e-6; // the same sums in another order
        made.soft = 0.2; // the cage cannot meet handles exactly; only held vertices are put where they belong
        made.all_soft = 1.5;
        made.updates = "bending";
        made.updated = maker({.bending = 0.01});
        made.other = maker({.cage_faces = 100});
        return made;
    }
};

} // namespace

INSTANTIATE_TEST_SUITE_P(SubspaceLaplacian, SurfaceContract, testing::Values(SubspaceLaplacian::traits()));

// That of the rest is kept in tests/bindings/oracles/test_oracles_reduced.py.
TEST_F(SubspaceLaplacian, keeps_the_volume_of_the_shape_that_enters)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    Points incoming = mesh.points();
    incoming.col(1) *= 1.4;
    const Points q = solved(mesh, shapes::ends(mesh, 2), {.poses = bend(60), .incoming = view(incoming)});
    EXPECT_LT(std::abs(volume(mesh, q) / volume(mesh, incoming) - 1), 1e-12);
}

TEST_F(SubspaceLaplacian, names_vertices_outside_a_given_cage)
{
    const SurfaceMesh mesh = shapes::bar(12, 3);
    Points box = shapes::cube().points();
    box = (box.rowwise() - box.colwise().mean()).eval();
    box = (box * 40.0).eval();
    EXPECT_NO_THROW(Method(mesh, {}, shapes::moved(shapes::cube(), box)).set_handles(shapes::ends(mesh, 2)));
    box.col(0) *= 0.3; // from -6 to 6, while the bar reaches 12
    Method method(mesh, {}, shapes::moved(shapes::cube(), box));
    expect_elements(refusal<InvalidConstraint>([&] { method.set_handles(shapes::ends(mesh, 2)); }),
                    Error::Element::vertex, shapes::where(mesh, [](const Vector3& p) { return p.x() > 6; }));
}

TEST_F(SubspaceLaplacian, refuses_an_open_cage)
{
    EXPECT_THROW(Method(shapes::octahedron(), {}, shapes::grid(2, 2)), InvalidMesh);
}

} // namespace sinew::test_subspace_laplacian
