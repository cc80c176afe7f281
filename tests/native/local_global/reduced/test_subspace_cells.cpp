// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/reduced/subspace_cells.h"

#include "native/operators/laplacian.h"
#include "tests/native/dense.h"
#include "tests/native/differences.h"
#include "tests/native/shapes.h"

#include <memory>

namespace sinew::test_subspace_cells {

/// A bar whose vertices follow 40 random combinations of themselves.
struct Setting
{
    SurfaceMesh mesh = shapes::bar(10, 3);
    SparseMatrix L = laplacian_matrix(mesh, Discretization::cotan);
    VectorX mass = mass_vector(mesh, Discretization::cotan_voronoi);
    RowMatrix B;
    Points y;
    std::vector<int> labels;
    std::vector<Handle> ends = shapes::ends(mesh, 2);
    std::vector<SubspaceCells::Pull> pulls;
    double curvature = 0.3;
    std::unique_ptr<SubspaceCells> cells;
    SubspaceCells::Base base;

    Setting()
    {
        // Hat functions of the distance from some vertices, so that the rows sum to 1; the unknowns at rest
        // are those that come closest to the mesh.
        std::vector<int> seeds;
        for (int v = 0; v < mesh.vertex_count(); v += mesh.vertex_count() / 40)
            seeds.push_back(v);
        B.resize(mesh.vertex_count(), static_cast<Eigen::Index>(seeds.size()));
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            for (std::size_t k = 0; k < seeds.size(); ++k)
                B(v, static_cast<Eigen::Index>(k)) =
                    std::exp(-0.5 * (mesh.point(v) - mesh.point(seeds[k])).squaredNorm());
            B.row(v) /= B.row(v).sum();
            labels.push_back(static_cast<int>(mesh.point(v).x() + 0.5) % 11);
        }
        y = mesh.points()(seeds, Eigen::all);
        for (int h : {0, 1})
            for (const int v : ends[h].vertices)
                pulls.push_back({h, v, 3.0});
        cells = std::make_unique<SubspaceCells>(B, L, mass, labels, 11, curvature, pulls, 2);
        base = cells->base(y);
    }

    std::vector<Points> targets(const Poses& poses) const
    {
        std::vector<Points> aims;
        for (const Pose& pose : poses)
            aims.push_back(shapes::transformed(y, pose) - y);
        return aims;
    }

    /// F, term by term from the header, with the best rotations.
    double energy(const Points& u, const Poses& poses) const
    {
        const Points rest = dense::product(B, y), x = dense::product(B, y + u), curved = L * x,
                     curved_rest = L * rest;
        double sum = 0.0;
        for (int k = 0; k < 11; ++k) {
            Matrix3 S = Matrix3::Zero();
            const auto rows = [&](auto&& visit) {
                for (int i = 0; i < mesh.vertex_count(); ++i) {
                    if (labels[i] != k)
                        continue;
                    for (SparseMatrix::InnerIterator it(L, i); it; ++it)
                        if (it.row() != i)
                            visit(-0.5 * it.value(), (x.row(i) - x.row(it.row())).transpose(),
                                  (rest.row(i) - rest.row(it.row())).transpose());
                    visit(curvature / mass[i], curved.row(i).transpose(), curved_rest.row(i).transpose());
                }
            };
            rows([&](double w, const Vector3& now, const Vector3& before) {
                S += w * now * before.transpose();
            });
            const Matrix3 R = dense::rotation_of(S);
            rows([&](double w, const Vector3& now, const Vector3& before) {
                sum += 0.5 * w * (now - R * before).squaredNorm();
            });
        }
        for (const auto& [handle, vertex, stiffness] : pulls)
            sum += 0.5 * stiffness *
                   (x.row(vertex).transpose() - apply(poses[handle], rest.row(vertex).transpose()))
                       .squaredNorm();
        return sum;
    }
};

Pose mean() { return shapes::still(); }
Poses twisted() { return {shapes::still(), shapes::turn({1, 0.2, 0}, 100, {5, 1, 1}, {0, 1, 0})}; }

TEST(SubspaceCells, has_the_energy_of_its_header)
{
    const Setting bar;
    const std::vector<Points> aims = bar.targets(twisted());
    SubspaceProblem problem(*bar.cells, bar.base, mean(), aims);
    shapes::Random random(5);
    for (double size : {0.01, 1.0}) {
        const Points u = size * random.dense(static_cast<int>(bar.y.rows()), 3);
        Points gradient;
        const double F = problem.evaluate(u, gradient);
        EXPECT_NEAR(F, bar.energy(u, twisted()) + 0.5 * bar.cells->anchor() * u.squaredNorm(), 1e-11 * F);
    }
}

TEST(SubspaceCells, the_gradient_is_that_of_differences)
{
    const Setting bar;
    const std::vector<Points> aims = bar.targets(twisted());
    SubspaceProblem problem(*bar.cells, bar.base, mean(), aims);
    shapes::Random random(6);
    const Points u = 0.3 * random.dense(static_cast<int>(bar.y.rows()), 3);
    Points gradient, other;
    problem.evaluate(u, gradient);
    for (int k = 0; k < 10; ++k) {
        const Points way = random.dense(static_cast<int>(bar.y.rows()), 3);
        const auto along = [&](double s) { return problem.evaluate(u + s * way, other); };
        EXPECT_NEAR(central_difference(along, 1e-5), gradient.cwiseProduct(way).sum(),
                    1e-7 * gradient.norm() * way.norm());
    }
}

TEST(SubspaceCells, two_unrelated_starts_meet_and_the_energy_never_rises)
{
    const Setting bar;
    const std::vector<Points> aims = bar.targets(twisted());
    Points found[2];
    for (int start : {0, 1}) {
        SubspaceProblem problem(*bar.cells, bar.base, mean(), aims);
        Points u = Points::Zero(bar.y.rows(), 3);
        if (start == 1) {
            for (int k = 0; k < 11; ++k)
                problem.set_rotation(k, shapes::rotation({1, 0.2, 0}, 10.0 * k));
            u = problem.unknowns_for_rotations();
        }
        double before = std::numeric_limits<double>::infinity();
        for (int k = 0; k < 40; ++k) {
            const SolveReport report =
                minimize(problem, u, {.max_iterations = 10, .tolerance = 0.0, .plain_steps = 4});
            EXPECT_LE(report.energy, before * (1 + 1e-12));
            before = report.energy;
        }
        found[start] = dense::product(bar.B, u);
    }
    EXPECT_LT(shapes::distance(found[0], found[1]), 1e-4);
}

TEST(SubspaceCells, keeps_a_volume_on_the_way)
{
    const Setting bar;
    const std::vector<Points> aims = bar.targets(twisted());
    const CoarseVolume coarse{bar.B, EnclosedVolume(bar.mesh.triangles(), bar.mesh.vertex_count())};
    const Points shape = dense::product(bar.B, bar.y);
    SubspaceProblem problem(*bar.cells, bar.base, mean(), aims, &coarse, shape);
    Points u = problem.unknowns_for_rotations();
    const SolveReport report =
        minimize(problem, u, {.max_iterations = 200, .tolerance = 1e-10, .plain_steps = 4});
    EXPECT_TRUE(report.converged);
    const Points x = shape + dense::product(bar.B, u);
    const double wanted = coarse.volume.of(view(shape));
    EXPECT_LT(std::abs(coarse.volume.of(view(x)) / wanted - 1), 1e-5); // as it admits
    // The gradient has no part along the constraint: no admitted way out lowers the energy.
    Points gradient;
    problem.evaluate(u, gradient);
    shapes::Random random(7);
    for (int k = 0; k < 10; ++k) {
        Points other = u + 1e-3 * random.dense(static_cast<int>(u.rows()), 3);
        problem.admit(other);
        Points ignored;
        EXPECT_GT(problem.evaluate(other, ignored), report.energy);
    }
}

} // namespace sinew::test_subspace_cells
