// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/thin_shell.h"

#include "tests/native/allocations.h"
#include "tests/native/methods/surface/contract.h"
#include "tests/native/methods/surface/linear/dense_shell.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>

namespace sinew::test_thin_shell {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::array every{Discretization::uniform, Discretization::cotan, Discretization::cotan_voronoi};

// The systems of 80-vertex meshes have condition numbers of up to 1e4 (order 1) to 1e9 (order 3)
// against an epsilon of 2e-16; the oracle rounds as much again.
constexpr double solved = 1e-6;

ThinShellOptions stiffness(double stretching, double bending, double variation)
{
    return {.stretching = {stretching}, .bending = {bending}, .variation = {variation}};
}

const std::vector<ThinShellOptions> orders{stiffness(1, 0, 0), stiffness(0, 1, 0), stiffness(0, 0, 1),
                                           stiffness(1, 0.5, 0), stiffness(0.3, 1, 2)};

Points solve(const ThinShell& shell, const Poses& poses)
{
    Points positions;
    shell.solve({poses}, positions);
    return positions;
}

Points bound_and_solved(const SurfaceMesh& mesh, const ThinShellOptions& options,
                        const std::vector<Handle>& handles, const Poses& poses)
{
    ThinShell shell(mesh, options);
    shell.set_handles(handles);
    return solve(shell, poses);
}

const Poses bent{shapes::still(), shapes::turn({0, 1, 0}, 40, {6, 0, 0}, {-1, 0.5, 2})};

auto maker(const ThinShellOptions& options)
{
    return [options](const SurfaceMesh& mesh) { return std::make_shared<ThinShell>(mesh, options); };
}

SurfaceTraits traits()
{
    std::vector<SurfaceVariant> variants{{"default", maker({})}};
    for (std::size_t order = 0; order < orders.size(); ++order)
        for (Discretization kind : every)
            for (bool basis : {true, false}) {
                ThinShellOptions options = orders[order];
                options.laplacian = kind;
                options.affine_basis = basis;
                variants.push_back({"stiffness " + std::to_string(order) + ", laplacian " +
                                        std::to_string(static_cast<int>(kind)) + (basis ? ", basis" : ""),
                                    maker(options)});
            }
    const auto drag = [](double t) {
        const double angle = 2 * shapes::pi * t;
        return Poses{shapes::still(), shapes::turn({0, 1, 0}, 60 * std::sin(angle), {9, 4, 0},
                                                   {2 * std::cos(angle) - 2, std::sin(angle), 0})};
    };
    // A fair surface overshoots its boundary by less than its own size: a step moves it by twice the
    // handle's.
    return {.name = "ThinShell",
            .variants = variants,
            .mesh = shapes::hill(8, 8),
            .large = shapes::hill(10, 9),
            .depth = 1.5,
            .bent = bent,
            .drag = drag,
            .drag_steps = 48,
            .follow = 2.0,
            .slack = 0.0,
            .translation = solved,
            .held = 1e-14,
            .similar = solved,
            .updates = "stretching",
            .updated = maker({.stretching = {0.7}}),
            .other = maker({.laplacian = Discretization::uniform})};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(ThinShell, SurfaceContract, testing::Values(traits()));

TEST(ThinShell, any_affine_motion_of_a_framed_plane_is_exact)
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
        EXPECT_LT(shapes::distance(bound_and_solved(plane, options, frame, {pose}),
                                   shapes::transformed(plane.points(), pose)),
                  solved);
}

struct DenseCase
{
    std::string name;
    SurfaceMesh mesh;
    ThinShellOptions options;
    std::vector<Handle> handles;
    Poses poses;
    double tolerance;
};

std::vector<DenseCase> dense_cases()
{
    std::vector<DenseCase> cases;
    const SurfaceMesh hill = shapes::hill(8, 8), bar = shapes::bar(6, 2);
    const std::vector<Handle> ends = shapes::ends(hill, 1.5);
    shapes::Random random(4);
    Stiffness painted(hill.vertex_count()), black(hill.vertex_count(), 1.0);
    for (double& k : painted)
        k = std::pow(10.0, 2 * random.signed_unit());
    for (int v : shapes::where(hill, [](const Vector3& p) { return p.y() > 4; }))
        black[v] = 0.0;
    std::vector<Handle> soft = ends;
    for (std::size_t k = 0; k < soft[1].vertices.size(); ++k)
        soft[1].weights.push_back(k % 5 == 0 ? 1.0 : k % 5 == 1 ? 0.0 : random.unit());
    soft.push_back({{40, 41, 42, soft[1].vertices[2]}, {0.5, 0.9, 0.1, 0.3}});
    const auto with_term = [](ThinShellOptions options, int term, const Stiffness& values) {
        (term == 0 ? options.stretching : term == 1 ? options.bending : options.variation) = values;
        return options;
    };
    const auto add = [&](const std::string& name, const SurfaceMesh& mesh, ThinShellOptions options,
                         const std::vector<Handle>& handles, double tolerance, const Poses& poses = bent) {
        for (Discretization kind : every)
            for (bool basis : {true, false}) {
                options.laplacian = kind;
                options.affine_basis = basis;
                cases.push_back({name + ", laplacian " + std::to_string(static_cast<int>(kind)), mesh,
                                 options, handles, poses, tolerance});
            }
    };
    for (const ThinShellOptions& options : orders)
        add("stiffness", hill, options, ends, solved);
    add("polygons", bar, stiffness(0.1, 1, 0), shapes::ends(bar, 1.1), solved);
    for (int term : {0, 1, 2})
        add("painted", hill, with_term(stiffness(0.2, 0.5, 0.1), term, painted), ends, solved);
    for (int term : {0, 1}) // a contrast of 1e6 costs six more digits
        add("painted black", hill, with_term(stiffness(0, 0, 0), term, black), ends, 1e-3);
    const Poses three{bent[0], bent[1], shapes::shift(0, 0, 3)};
    add("soft handles", hill, stiffness(0.2, 1, 0), soft, 1e-8, three); // condition about 1e5
    return cases;
}

TEST(ThinShell, solves_as_dense_matrices_built_from_angles_do)
{
    for (const DenseCase& at : dense_cases()) {
        SCOPED_TRACE(at.name);
        double energy = 0;
        const Points expected = DenseShell(at.mesh, at.options, at.handles).solve(at.poses, &energy);
        ThinShell shell(at.mesh, at.options);
        shell.set_handles(at.handles);
        Points positions;
        const SolveReport report = shell.solve({at.poses}, positions);
        EXPECT_LT(shapes::distance(positions, expected), at.tolerance);
        EXPECT_NEAR(report.energy, energy, at.tolerance * energy);
        EXPECT_LT(report.residual, 1e-8);
        EXPECT_TRUE(report.converged);
        EXPECT_EQ(report.iterations, 1);
    }
}

TEST(ThinShell, soft_handles_become_hard_as_their_weight_nears_one_and_let_go_near_zero)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const Points hard = bound_and_solved(mesh, {}, handles, bent);
    const auto softened = [&](double weight) {
        handles[1].weights.assign(handles[1].vertices.size(), weight);
        return bound_and_solved(mesh, {}, handles, bent);
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

TEST(ThinShell, displaces_what_enters_as_it_displaces_the_rest)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    const Points incoming = shapes::transformed(mesh.points(), shapes::turn({1, 2, 0}, 30));
    const Poses lifted{shapes::still(), shapes::shift(0, 0, 2)};
    for (bool basis : {true, false}) {
        ThinShell shell(mesh, {.affine_basis = basis});
        shell.set_handles(shapes::ends(mesh, 1.5));
        Points positions;
        shell.solve({.poses = lifted, .incoming = view(incoming)}, positions);
        EXPECT_LT(shapes::distance(positions - incoming, solve(shell, lifted) - mesh.points()), 1e-10);
    }
}

TEST(ThinShell, only_the_ratio_of_the_stiffnesses_counts)
{
    const SurfaceMesh mesh = shapes::hill(7, 6);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const Points one = bound_and_solved(mesh, stiffness(0.3, 1, 0.2), handles, bent);
    for (double scale : {1e-6, 1e6})
        EXPECT_LT(shapes::distance(
                      bound_and_solved(mesh, stiffness(0.3 * scale, scale, 0.2 * scale), handles, bent), one),
                  solved);
}

TEST(ThinShell, is_linear_in_the_poses)
{
    const SurfaceMesh mesh = shapes::hill(8, 7);
    ThinShell shell(mesh);
    shell.set_handles(shapes::ends(mesh, 1.5));
    const Poses a{shapes::shift(1, 2, 3), shapes::still()}, b = bent;
    Poses sum = b;
    sum[0].col(3) += Vector3(1, 2, 3);
    const Points together = solve(shell, a) + solve(shell, b) - mesh.points();
    EXPECT_LT(shapes::distance(solve(shell, sum), together), 1e-9);
}

TEST(ThinShell, solves_after_the_first_allocate_nothing_in_proportion_to_the_mesh)
{
    if (!allocations::counted())
        GTEST_SKIP() << "nobody counts here";
    const SurfaceMesh mesh = shapes::hill(60, 60);
    const auto a_number_a_vertex = sizeof(double) * mesh.vertex_count();
    std::vector<Handle> soft = shapes::ends(mesh, 1.5);
    soft[1].weights.assign(soft[1].vertices.size(), 0.5);
    const Poses poses{shapes::still(), shapes::shift(0, 0, 1)};
    for (const bool basis : {true, false})
        for (const std::vector<Handle>& handles : {shapes::ends(mesh, 1.5), soft}) {
            ThinShell shell(mesh, {.affine_basis = basis});
            Points positions;
            const allocations::Count count(a_number_a_vertex);
            shell.set_handles(handles);
            shell.solve({poses}, positions);
            const int first = count.so_far();
            EXPECT_GT(first, 0);
            for (int k = 0; k < 3; ++k)
                shell.solve({poses}, positions);
            EXPECT_EQ(count.so_far(), first);
        }
}

TEST(ThinShell, another_stiffness_gives_what_a_new_object_gives)
{
    const SurfaceMesh mesh = shapes::hill(8, 7);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    ThinShell shell(mesh, stiffness(0.1, 1, 0));
    shell.set_handles(handles);
    solve(shell, bent);
    EXPECT_EQ(shell.set_stiffness({2.0}, {0.5}, {0.0}).factorizations, 2);
    EXPECT_EQ(solve(shell, bent), bound_and_solved(mesh, stiffness(2, 0.5, 0), handles, bent));
}

TEST(ThinShell, refuses_stiffnesses_that_mean_nothing)
{
    const SurfaceMesh mesh = shapes::cube();
    const auto refused = [&](const Stiffness& s, const Stiffness& b, const Stiffness& v) {
        EXPECT_THROW(ThinShell(mesh, {.stretching = s, .bending = b, .variation = v}), InvalidOption);
        ThinShell shell(mesh);
        shell.set_handles({{{0}, {}}});
        EXPECT_THROW(shell.set_stiffness(s, b, v), InvalidOption);
        EXPECT_EQ(solve(shell, {shapes::still()}), mesh.points());
    };
    for (double bad : {-1.0, nan, std::numeric_limits<double>::infinity()}) {
        refused({bad}, {1.0}, {0.0});
        refused({0.0}, {bad}, {0.0});
        refused({0.0}, {1.0}, {bad});
    }
    refused({0.0}, {0.0}, {0.0});
    refused({0.0}, {1.0, 1.0}, {0.0});
    refused({}, {1.0}, {0.0});
    refused({0.0}, Stiffness(8, 0.0), {0.0});
    Stiffness painted(8, 1.0);
    painted[3] = painted[5] = -1;
    const auto make = [&] { ThinShell(mesh, {.bending = painted}); };
    expect_elements(refusal<InvalidOption>(make), Error::Element::vertex, {3, 5});
}

} // namespace sinew::test_thin_shell
