// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/handles/constrained_system.h"

#include "native/core/errors.h"
#include "native/operators/laplacian.h"
#include "tests/native/shapes.h"

// Its solutions and energies, with loads and soft handles, are those of dense matrices in
// tests/bindings/oracles/test_oracles_surface.py, through the methods that it solves.
namespace sinew::test_constrained_system {

TEST(ConstrainedSystem, what_comes_after_its_factor_may_fail_and_then_nothing_has_changed)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    const Components parts = connected_components(mesh);
    const auto L = std::make_shared<SparseMatrix>(laplacian_matrix(mesh, Discretization::cotan));
    const Poses moved{shapes::still(), shapes::turn({0, 1, 0}, 40, {6, 0, 0}, {-1, 0.5, 2})};
    const Targets targets{moved, view(mesh.points()), {}, nullptr};
    std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const Regions hard(handles, parts);
    handles[1].weights.assign(handles[1].vertices.size(), 0.7);
    ConstrainedSystem system;
    system.factorize(L, Regions(handles, parts));
    Points before, after;
    system.solve(targets, before);
    const auto fail = [] { throw Cancelled("stop"); };
    EXPECT_THROW(system.factorize(L, hard, fail), Cancelled);
    system.solve(targets, after);
    EXPECT_EQ(after, before);
    BindReport report;
    system.report(report);
    EXPECT_EQ(report.factorizations, 1);
    EXPECT_THROW(ConstrainedSystem().factorize(L, hard, fail), Cancelled);
}

} // namespace sinew::test_constrained_system
