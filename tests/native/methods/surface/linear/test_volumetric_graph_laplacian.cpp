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

Points on_the_surface_only(const SurfaceMesh& mesh, const std::vector<Handle>& handles, const Poses& poses)
{
    LaplacianEditing method(mesh, {.transforms = LocalTransforms::from_handles});
    method.set_handles(handles);
    Points positions;
    method.solve({poses}, positions);
    return positions;
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
        made.similar = made.scaled = 1e-8;
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
    shapes::Random random(6);
    for (const SurfaceMesh& mesh : {egg(3), shapes::bar(8, 6)})
        for (Discretization kind :
             {Discretization::uniform, Discretization::cotan, Discretization::cotan_voronoi})
            for (double weight : {1.0, 0.6})
                for (double alpha : {1.0, 7.0}) {
                    const int n = mesh.vertex_count();
                    std::vector<Handle> handles = shapes::ends(mesh, 2);
                    handles[1].weights.assign(handles[1].vertices.size(), weight);
                    Method method(mesh, {.volume = alpha, .laplacian = kind});
                    method.set_handles(handles);
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
                    for (int i = 0; i < nodes; ++i)
                        if (const double sum = W.row(i).sum(); sum > 0) {
                            D.row(i) = -W.row(i) / sum;
                            D(i, i) = 1;
                        }
                    const MatrixX surface = laplacian_matrix(mesh, kind);
                    const VectorX m = mass_vector(mesh, kind);
                    L.topLeftCorner(n, n) = dense::with_positive_weights(surface);
                    L += MatrixX(W.rowwise().sum().asDiagonal()) - W;
                    MatrixX A = alpha / m.mean() * dense::product(D.transpose(), D);
                    A.topLeftCorner(n, n) += dense::product(surface, m.cwiseInverse().asDiagonal() * surface);

                    // The field of the second handle; a soft one pulls it as it pulls positions.
                    VectorX s = VectorX::Zero(nodes), b = s;
                    Points x = p, rhs = Points::Zero(nodes, 3);
                    MatrixX K = A;
                    const Matrix3 R = shapes::rotation({1, 2, 0}, 130), B = random.matrix(),
                                  S = Matrix3::Identity() + 0.2 * (B + B.transpose());
                    const Pose pose = shapes::affine(R * S, {1, 2, -3});
                    std::vector<bool> held(nodes, false);
                    for (int v : handles[0].vertices)
                        held[v] = true;
                    double energy = 0.0;
                    for (int v : handles[1].vertices) {
                        const Vector3 target = apply(pose, mesh.point(v));
                        if (weight == 1.0) {
                            held[v] = true;
                            s[v] = 1;
                            x.row(v) = target.transpose();
                        } else {
                            const double pull = weight / (1 - weight);
                            b[v] = pull * L(v, v);
                            L(v, v) *= 1 + pull;
                            rhs.row(v) = pull * A(v, v) * target.transpose();
                            K(v, v) *= 1 + pull;
                        }
                    }
                    std::vector<int> free;
                    for (int i = 0; i < nodes; ++i)
                        if (!held[i])
                            free.push_back(i);
                    s = dense::solution(L, b, s, free);
                    const MatrixX delta =
                                      m.cwiseInverse().asDiagonal() * dense::product(surface, mesh.points()),
                                  inner = dense::product(D, p);
                    MatrixX turned = delta, inside = inner;
                    for (int i = 0; i < nodes; ++i) {
                        const Matrix3 T = Eigen::Quaterniond::Identity()
                                              .slerp(s[i], Eigen::Quaterniond(R))
                                              .toRotationMatrix() *
                                          (s[i] * S + (1 - s[i]) * Matrix3::Identity());
                        if (i < n)
                            turned.row(i) = (T * delta.row(i).transpose()).transpose();
                        inside.row(i) = (T * inner.row(i).transpose()).transpose();
                    }
                    rhs.topRows(n) += dense::product(surface, turned);
                    rhs += alpha / m.mean() * dense::product(D.transpose(), inside);
                    x = dense::solution(K, rhs, x, free);
                    const MatrixX misfit =
                        m.cwiseInverse().asDiagonal() * dense::product(surface, x.topRows(n)) - turned;
                    energy = 0.5 * m.dot(misfit.rowwise().squaredNorm()) +
                             0.5 * alpha / m.mean() * (dense::product(D, x) - inside).squaredNorm();
                    if (weight < 1.0)
                        for (int v : handles[1].vertices)
                            energy += 0.5 * weight / (1 - weight) * A(v, v) *
                                      (x.row(v).transpose() - apply(pose, mesh.point(v))).squaredNorm();

                    Points found;
                    const SolveReport report = method.solve({{shapes::still(), pose}}, found);
                    // Condition numbers are up to 1e7.
                    EXPECT_LT(shapes::distance(found, x.topRows(n)), 1e-8 * shapes::size(found));
                    EXPECT_NEAR(report.energy, energy, 1e-8 * energy);
                    EXPECT_LT(report.residual, 1e-9);
                }
}

TEST_F(VolumetricGraphLaplacian, without_volume_or_without_an_inside_is_laplacian_editing_from_handles)
{
    const SurfaceMesh sheet = shapes::hill(8, 8), body = egg(3);
    EXPECT_LT(shapes::distance(solved(body, shapes::ends(body, 1.5), {.poses = bent}, {.volume = 0}),
                               on_the_surface_only(body, shapes::ends(body, 1.5), bent)),
              1e-9);
    Method method(sheet);
    method.set_handles(shapes::ends(sheet, 1.5));
    EXPECT_EQ(method.inner_points().rows(), 0);
    Points q;
    method.solve({bent}, q);
    EXPECT_LT(shapes::distance(q, on_the_surface_only(sheet, shapes::ends(sheet, 1.5), bent)), 1e-9);
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
        Method method(mesh);
        method.set_handles({{{0, 1, 2}, {}}});
        const auto edges = method.graph_edges();
        std::vector<bool> joined(n + method.inner_points().rows(), false);
        std::fill_n(joined.begin(), n, true);
        for (bool more = true; more;) {
            more = false;
            for (const auto& [a, b] : edges)
                if (joined[a] != joined[b])
                    joined[a] = joined[b] = more = true;
        }
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
