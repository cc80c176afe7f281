// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/volumetric_graph_laplacian.h"

#include "native/methods/surface/linear/laplacian_editing.h"
#include "native/methods/surface/linear/thin_shell.h"
#include "native/operators/laplacian.h"
#include "native/solvers/smallest_factor.h"
#include "tests/native/dense.h"
#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>

namespace sinew::test_volumetric_graph_laplacian {

namespace {

/// A crooked egg, long in x, without any symmetry that leaves a choice to rounding; with inner points in a
/// shell and a lattice.
SurfaceMesh egg(int level)
{
    const SurfaceMesh ball = shapes::sphere(level);
    Points p = ball.points();
    for (int v = 0; v < p.rows(); ++v) {
        const double x = p(v, 0), y = p(v, 1), z = p(v, 2);
        p.row(v) = Eigen::RowVector3d(6 * x, (3.6 + 0.5 * x) * y + 0.2 * x * x,
                                      (3.1 - 0.2 * x + 0.1 * y) * z + 0.3 * x * y);
    }
    return shapes::moved(ball, p);
}

class VolumetricGraphLaplacian
    : public SurfaceFixture<sinew::VolumetricGraphLaplacian, VolumetricGraphLaplacianOptions>
{
public:
    static SurfaceTraits traits(const std::string& name, const SurfaceMesh& mesh, const SurfaceMesh& large,
                                int half_turns)
    {
        Options heavy, uniform;
        heavy.volume = 20;
        uniform.laplacian = Discretization::uniform;
        SurfaceTraits made = linear(name, {{"volume 1", maker(), 2, true, 1e-8},
                                           {"volume 20", maker(heavy), 2, true, 1e-8},
                                           {"no volume", maker({.volume = 0}), 2, true, 1e-8},
                                           {"uniform", maker(uniform), 2, true, 1e-8}});
        made.mesh = mesh;
        made.large = large;
        made.many = egg(5);
        made.follow = 3.0;
        made.rest = made.incoming = 1e-11;
        made.translation = made.rigid.emplace(1e-9);
        made.similar = 1e-8;
        made.rides = 1e-9;
        made.turns_incoming = made.parts_apart = made.many_enter = true;
        made.half_turns = half_turns;
        made.updates = "volume";
        made.updated = maker(heavy);
        made.other = maker(uniform);
        return made;
    }
};

} // namespace

INSTANTIATE_TEST_SUITE_P(VolumetricGraphLaplacian, SurfaceContract,
                         testing::Values(VolumetricGraphLaplacian::traits("Sheet", shapes::hill(8, 8),
                                                                          shapes::hill(10, 9), 81),
                                         VolumetricGraphLaplacian::traits("Body", egg(3), egg(4), 258)));

TEST_F(VolumetricGraphLaplacian, solves_what_dense_matrices_do)
{
    using dense::product;
    shapes::Random random(6);
    for (const SurfaceMesh& mesh : {egg(3), shapes::bar(8, 6)})
        for (Discretization kind :
             {Discretization::uniform, Discretization::cotan, Discretization::cotan_voronoi})
            for (const auto& [weight, alpha] : {std::pair(1.0, 1.0), {1.0, 7.0}, {0.6, 1.0}, {0.6, 7.0}}) {
                const int n = mesh.vertex_count();
                std::vector<Handle> handles = shapes::ends(mesh, 2);
                handles[1].weights.assign(handles[1].vertices.size(), weight);
                const Method method = bound(mesh, {.volume = alpha, .laplacian = kind}, handles);
                const int nodes = n + static_cast<int>(method.inner_points().rows());
                ASSERT_GT(nodes, n + 15);
                Points p(nodes, 3);
                p << mesh.points(), method.inner_points();

                MatrixX W = MatrixX::Zero(nodes, nodes), D = W, L = W;
                double mean_edge = 0.0;
                for (const auto& [a, b] : mesh.edges())
                    mean_edge += (p.row(a) - p.row(b)).norm() / static_cast<double>(mesh.edges().size());
                for (const auto& [a, b] : method.graph_edges())
                    W(a, b) = W(b, a) = mean_edge / (p.row(a) - p.row(b)).norm();
                const VectorX sums = W.rowwise().sum();
                for (int i = 0; i < nodes; ++i)
                    if (sums[i] > 0) {
                        D.row(i) = -W.row(i) / sums[i];
                        D(i, i) = 1;
                    }
                const MatrixX surface = laplacian_matrix(mesh, kind);
                const VectorX m = mass_vector(mesh, kind);
                const MatrixX by_mass = m.cwiseInverse().asDiagonal() * surface;
                L.topLeftCorner(n, n) = dense::with_positive_weights(surface);
                L += MatrixX(sums.asDiagonal()) - W;
                MatrixX A = alpha / m.mean() * product(D.transpose(), D);
                A.topLeftCorner(n, n) += product(surface, by_mass);

                // The field of the second handle; a soft one pulls it as it pulls positions.
                const Matrix3 R = shapes::rotation({1, 2, 0}, 130), B = random.matrix(),
                              S = Matrix3::Identity() + 0.2 * (B + B.transpose());
                const Pose pose = shapes::affine(R * S, {1, 2, -3});
                const Points targets = shapes::transformed(p, pose);
                const double pull = weight < 1.0 ? weight / (1 - weight) : 0.0;
                VectorX s = VectorX::Zero(nodes), b = s, springs = s;
                Points x = p;
                for (int v : handles[1].vertices) {
                    x.row(v) = targets.row(v);
                    s[v] = 1;
                    b[v] = pull * L(v, v);
                    springs[v] = pull * A(v, v);
                    L(v, v) *= 1 + pull;
                }
                std::vector<int> free = shapes::numbers(0, nodes);
                for (const Handle& handle : handles)
                    if (handle.weights.empty() || weight == 1.0)
                        std::erase_if(free, [&](int i) { return std::ranges::count(handle.vertices, i); });
                s = dense::solution(L, b, s, free);
                const MatrixX delta = product(by_mass, mesh.points()), inner = product(D, p);
                MatrixX turned = delta, inside = inner;
                for (int i = 0; i < nodes; ++i) {
                    const Eigen::Quaterniond part =
                        Eigen::Quaterniond::Identity().slerp(s[i], Eigen::Quaterniond(R));
                    const Matrix3 T = part.toRotationMatrix() * (s[i] * S + (1 - s[i]) * Matrix3::Identity());
                    if (i < n)
                        turned.row(i) *= T.transpose();
                    inside.row(i) *= T.transpose();
                }
                MatrixX rhs = springs.asDiagonal() * targets;
                rhs.topRows(n) += product(surface, turned);
                rhs += alpha / m.mean() * product(D.transpose(), inside);
                x = dense::solution(A + MatrixX(springs.asDiagonal()), rhs, x, free);
                const MatrixX misfit = product(by_mass, x.topRows(n)) - turned;
                const double energy = 0.5 * m.dot(misfit.rowwise().squaredNorm()) +
                                      0.5 * alpha / m.mean() * (product(D, x) - inside).squaredNorm() +
                                      0.5 * springs.dot((x - targets).rowwise().squaredNorm());

                const auto [found, report] = solve(method, {shapes::still(), pose});
                // Condition numbers are up to 1e7.
                EXPECT_LT(shapes::distance(found, x.topRows(n)), 1e-8 * shapes::size(found));
                EXPECT_NEAR(report.energy, energy, 1e-8 * energy);
                EXPECT_LT(report.residual, 1e-9);
            }
}

TEST_F(VolumetricGraphLaplacian, without_volume_or_without_an_inside_is_laplacian_editing_from_handles)
{
    for (const auto& [mesh, volume] : {std::pair(egg(3), 0.0), {shapes::hill(8, 8), 1.0}}) {
        const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
        const Method method = bound(mesh, {.volume = volume}, handles);
        LaplacianEditing editing(mesh, {.transforms = LocalTransforms::from_handles});
        editing.set_handles(handles);
        EXPECT_EQ(method.inner_points().rows(), 0);
        EXPECT_LT(shapes::distance(solve(method, bent).positions, solve(editing, bent).positions), 1e-9);
    }
}

TEST_F(VolumetricGraphLaplacian, fills_parts_that_are_turned_inside_out)
{
    const SurfaceMesh mesh = egg(3);
    EXPECT_LT(shapes::distance(solved(shapes::inside_out(mesh), shapes::ends(mesh, 1.5), {.poses = bent}),
                               solved(mesh, shapes::ends(mesh, 1.5), {.poses = bent})),
              1e-9);
}

TEST_F(VolumetricGraphLaplacian, joins_every_inner_point_to_the_surface)
{
    for (const SurfaceMesh& mesh : {egg(3), egg(4), shapes::bar(20, 6), shapes::messy()}) {
        const int n = mesh.vertex_count();
        const Method method = bound(mesh, {}, {{{0, 1, 2}, {}}});
        std::vector<bool> joined(n + method.inner_points().rows(), false);
        std::fill_n(joined.begin(), n, true);
        for (std::size_t round = 0; round < joined.size(); ++round)
            for (const auto& [a, b] : method.graph_edges())
                joined[a] = joined[b] = joined[a] || joined[b];
        EXPECT_EQ(std::ranges::count(joined, false), 0);
    }
}

TEST_F(VolumetricGraphLaplacian, handles_of_a_part_that_overlaps_do_not_count)
{
    const SurfaceMesh mesh = egg(3), both = shapes::joined(mesh, mesh, {0, 3, 0});
    const int n = mesh.vertex_count();
    std::vector<Handle> more = shapes::ends(mesh, 1.5);
    more.push_back({{n + 3, n + 40}, {}});
    EXPECT_LT(shapes::distance(
                  solved(both, more, {.poses = {bent[0], bent[1], shapes::turn({1, 0, 1}, 140)}}).topRows(n),
                  solved(mesh, shapes::ends(mesh, 1.5), {.poses = bent})),
              1e-9);
}

TEST_F(VolumetricGraphLaplacian, has_factors_of_less_than_four_thin_shells)
{
    if (smallest_factor() != Ordering::nested_dissection)
        GTEST_SKIP() << "minimum degree has larger factors than nested dissection";
    const SurfaceMesh mesh = egg(6);
    ThinShell shell(mesh);
    Method method(mesh);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const auto alone = static_cast<double>(shell.set_handles(handles).factor_bytes),
               together = static_cast<double>(method.set_handles(handles).factor_bytes);
    EXPECT_LT(together, 4.0 * alone) << "measured: 3.85";
}

} // namespace sinew::test_volumetric_graph_laplacian
