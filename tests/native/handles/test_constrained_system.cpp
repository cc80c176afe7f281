// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/handles/constrained_system.h"

#include "native/core/errors.h"
#include "native/operators/laplacian.h"
#include "tests/native/shapes.h"

// Its solutions and energies, with loads and soft handles, are those of dense matrices in
// tests/bindings/oracles/test_oracles_surface.py, through the methods that it solves.
namespace sinew::test_constrained_system {

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
