// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/thin_shell.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <string>

namespace sinew::test_thin_shell {

namespace {

constexpr std::array every{Discretization::uniform, Discretization::cotan, Discretization::cotan_voronoi};

// The systems of 80-vertex meshes have condition numbers of up to 1e4 (order 1) to 1e9 (order 3)
// against an epsilon of 2e-16.
constexpr double rounding = 1e-6;

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
        made.translation = made.similar = rounding;
        made.held = 1e-14;
        made.updates = "stretching";
        made.updated = maker({.stretching = {0.7}});
        made.other = maker({.laplacian = Discretization::uniform});
        return made;
    }
};

} // namespace

INSTANTIATE_TEST_SUITE_P(ThinShell, SurfaceContract, testing::Values(ThinShell::traits()));

TEST_F(ThinShell, any_affine_motion_of_a_framed_plane_is_exact)
{
    // L x = 0 inside a planar mesh, so affine displacements cost nothing where L sees no border:
    // a frame three rings deep hides it from every order.
    const SurfaceMesh plane = shapes::grid(12, 11, 0.5, 0.2);
    const std::vector<Handle> frame{{shapes::where(plane,
                                                   [](const Vector3& p) {
                                                       return p.x() < 1.2 || p.y() < 1.2 || p.x() > 4.8 ||
                                                              p.y() > 4.3;
                                                   }),
                                     {}}};
    Matrix3 A;
    A << 1.2, 0.3, 0, -0.4, 0.8, 0.1, 0.5, 0.2, 2;
    const Pose pose = shapes::affine(A, {1, 2, 3});
    for (const ThinShellOptions& options : orders)
        EXPECT_LT(shapes::distance(solved(plane, frame, {.poses = {pose}}, options),
                                   shapes::transformed(plane.points(), pose)),
                  rounding);
}

TEST_F(ThinShell, soft_handles_become_hard_as_their_weight_nears_one_and_let_go_near_zero)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const Points hard = solved(mesh, handles, {.poses = bent});
    const auto softened = [&](double weight) {
        handles[1].weights.assign(handles[1].vertices.size(), weight);
        return solved(mesh, handles, {.poses = bent});
    };
    double before = 1.0;
    for (double gap : {1e-2, 1e-4, 1e-6, 1e-8}) {
        const double error = shapes::distance(softened(1 - gap), hard);
        EXPECT_LT(error, 0.05 * before) << gap; // the error falls as 1 - w, a factor of 100 each
        before = error;
    }
    EXPECT_LT(before, 1e-5);
    for (double gap : {1e-10, 1e-12, 1e-15})
        EXPECT_LT(shapes::distance(softened(1 - gap), hard), 1e-4) << gap;
    // One hard handle at rest against pulls of 1e-12: moves of some 1e-12 x the softest mode.
    EXPECT_LT(shapes::distance(softened(1e-12), mesh.points()), 1e-6);
}

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

TEST_F(ThinShell, only_the_ratio_of_the_stiffnesses_counts)
{
    const SurfaceMesh mesh = shapes::hill(7, 6);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const Points one = solved(mesh, handles, {.poses = bent}, stiffness(0.3, 1, 0.2));
    for (double scale : {1e-6, 1e6})
        EXPECT_LT(
            shapes::distance(
                solved(mesh, handles, {.poses = bent}, stiffness(0.3 * scale, scale, 0.2 * scale)), one),
            rounding);
}

} // namespace sinew::test_thin_shell
