// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/handles/constrained_system.h"

#include "native/core/errors.h"
#include "native/operators/laplacian.h"
#include "tests/native/dense.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_constrained_system {

namespace {

const Poses moved{shapes::still(), shapes::turn({0, 1, 0}, 40, {6, 0, 0}, {-1, 0.5, 2}),
                  shapes::shift(0, 0, 3)};

std::vector<Handle> soft_and_hard(const SurfaceMesh& mesh)
{
    std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    handles[1].weights.assign(handles[1].vertices.size(), 0.7);
    handles.push_back({{40, 41, handles[1].vertices[0]}, {0.5, 1.0, 0.3}});
    return handles;
}

auto matrix_of(const SurfaceMesh& mesh)
{
    return std::make_shared<SparseMatrix>(laplacian_matrix(mesh, Discretization::cotan));
}

} // namespace

TEST(ConstrainedSystem, finds_what_dense_matrices_find_and_reports_its_energy)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    const int n = mesh.vertex_count();
    const Regions regions(soft_and_hard(mesh), connected_components(mesh));
    const Targets targets{moved, view(mesh.points()), {}, nullptr};
    const auto wanted = [&](int v, int h) -> Eigen::RowVector3d {
        return targets.position(v, h).transpose() - mesh.points().row(v);
    };
    const MatrixX A = laplacian_matrix(mesh, Discretization::cotan);
    for (const bool loaded : {true, false}) {
        const MatrixX source = (loaded ? 1.0 : 0.0) * shapes::Random(1).dense(n, 3);
        MatrixX K = A, b = source, d = MatrixX::Zero(n, 3);
        for (const SoftConstraint& s : regions.soft()) {
            K(s.vertex, s.vertex) += s.stiffness() * A(s.vertex, s.vertex);
            b.row(s.vertex) += s.stiffness() * A(s.vertex, s.vertex) * wanted(s.vertex, s.handle);
        }
        std::vector<int> free;
        for (int v = 0; v < n; ++v) {
            if (regions.is_free(v))
                free.push_back(v);
            else
                d.row(v) = wanted(v, regions.hard(v));
        }
        d = dense::solution(K, b, d, free);
        double energy = 0.5 * (d.transpose() * A * d).trace() - (source.transpose() * d).trace() + 0.5 * 1000;
        for (const SoftConstraint& s : regions.soft())
            energy += 0.5 * s.stiffness() * A(s.vertex, s.vertex) *
                      (d.row(s.vertex) - wanted(s.vertex, s.handle)).squaredNorm();

        ConstrainedSystem system;
        system.factorize(matrix_of(mesh), regions);
        for (int time : {1, 2}) { // nothing of the frame before is left
            SCOPED_TRACE(time);
            Points positions;
            const ConstrainedSystem::Source fill = [&](RowMatrix& rows) {
                rows = source;
                return 1000.0;
            };
            const SolveReport report =
                system.solve(targets, positions, loaded ? fill : ConstrainedSystem::Source());
            EXPECT_LT((positions - mesh.points() - d).cwiseAbs().maxCoeff(), 1e-11); // a condition of 1e3
            EXPECT_NEAR(report.energy, loaded ? energy : energy - 500, 1e-10 * (energy + 1000));
            EXPECT_LT(report.residual, 1e-12);
        }
    }
}

TEST(ConstrainedSystem, what_comes_after_its_factor_may_fail_and_then_nothing_has_changed)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    const Components parts = connected_components(mesh);
    const Targets targets{moved, view(mesh.points()), {}, nullptr};
    ConstrainedSystem system;
    system.factorize(matrix_of(mesh), Regions(soft_and_hard(mesh), parts));
    Points before, after;
    system.solve(targets, before);
    std::vector<Handle> others = soft_and_hard(mesh);
    others[1].weights.clear();
    int tried = 0;
    const auto fail = [&] {
        ++tried;
        throw Cancelled("stop");
    };
    EXPECT_THROW(system.factorize(matrix_of(mesh), Regions(others, parts), fail), Cancelled);
    EXPECT_EQ(tried, 1);
    system.solve(targets, after);
    EXPECT_EQ(after, before);
    BindReport report;
    system.report(report);
    EXPECT_EQ(report.factorizations, 1);
    EXPECT_THROW(ConstrainedSystem().factorize(matrix_of(mesh), Regions(others, parts), fail), Cancelled);
}

} // namespace sinew::test_constrained_system
