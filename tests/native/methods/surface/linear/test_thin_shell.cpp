// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/thin_shell.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <string>

namespace sinew::test_thin_shell {

namespace {

constexpr std::array every{Discretization::uniform, Discretization::cotan, Discretization::cotan_voronoi};

ThinShellOptions stiffness(double stretching, double bending, double variation)
{
    return {.stretching = {stretching}, .bending = {bending}, .variation = {variation}};
}

const std::vector<ThinShellOptions> orders{stiffness(1, 0, 0), stiffness(0, 1, 0), stiffness(0, 0, 1),
                                           stiffness(1, 0.5, 0), stiffness(0.3, 1, 2)};

class ThinShell : public SurfaceFixture<sinew::ThinShell, ThinShellOptions>
{
public:
    static SurfaceTraits traits()
    {
        std::vector<SurfaceVariant> variants{{"default", maker()}};
        for (std::size_t order = 0; order < orders.size(); ++order)
            for (Discretization kind : every)
                for (bool basis : {true, false}) {
                    Options options = orders[order];
                    options.laplacian = kind;
                    options.affine_basis = basis;
                    variants.push_back({"stiffness " + std::to_string(order) + ", laplacian " +
                                            std::to_string(static_cast<int>(kind)) + (basis ? ", basis" : ""),
                                        maker(options)});
                }
        // A fair surface overshoots its boundary by less than its own size: a step moves it by twice the
        // handle's.
        SurfaceTraits made = linear("ThinShell", variants);
        made.many_soft = true;
        // Systems of 80-vertex meshes have condition numbers of up to 1e4 (order 1) to 1e9 (order 3).
        made.translation = made.similar = 1e-6;
        made.held = 1e-14;
        made.updates = "stretching";
        made.updated = maker({.stretching = {0.7}});
        made.other = maker({.laplacian = Discretization::uniform});
        return made;
    }
};

} // namespace

// The formula is in tests/bindings/oracles/test_oracles_surface.py, closed forms in surfaces/test_annulus.py.
INSTANTIATE_TEST_SUITE_P(ThinShell, SurfaceContract, testing::Values(ThinShell::traits()));

TEST_F(ThinShell, displaces_what_enters_as_it_displaces_the_rest)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    const Points incoming = shapes::transformed(mesh.points(), shapes::turn({1, 2, 0}, 30));
    const Poses lifted{shapes::still(), shapes::shift(0, 0, 2)};
    for (bool basis : {true, false}) {
        const Method shell = bound(mesh, {.affine_basis = basis}, shapes::ends(mesh, 1.5));
        EXPECT_LT(shapes::distance(solve(shell, lifted, {.incoming = view(incoming)}).positions - incoming,
                                   solve(shell, lifted).positions - mesh.points()),
                  1e-10);
    }
}

TEST_F(ThinShell, on_the_multigrid_ends_within_a_product_when_cancelled_and_begins_from_a_shape)
{
    on_the_multigrid({.solver = SystemSolver::factor}, {.solver = SystemSolver::multigrid});
}

} // namespace sinew::test_thin_shell
