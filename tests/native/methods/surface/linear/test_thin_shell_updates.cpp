// SPDX-License-Identifier: GPL-3.0-or-later
// Binds that keep most of the factor that stands.
#include "native/methods/surface/linear/thin_shell.h"

#include "native/solvers/engines/cholmod_factor.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sinew::test_thin_shell_updates {

namespace {

const Poses bent{shapes::still(), shapes::turn({0, 1, 0}, 40, {6, 0, 0}, {-1, 0.5, 2})};
const Poses raised{bent[0], bent[1], shapes::shift(0, 0, 3)};

/// Vertices [x, x + width) x [y, y + width) of a grid of columns + 1 vertices a row.
std::vector<int> patch(int columns, int x, int y, int width)
{
    std::vector<int> vertices;
    for (int j = y; j < y + width; ++j)
        for (int i = x; i < x + width; ++i)
            vertices.push_back(j * (columns + 1) + i);
    return vertices;
}

std::vector<Handle> with(std::vector<Handle> handles, const std::vector<int>& vertices)
{
    handles.push_back({vertices, {}});
    return handles;
}

Points solve(const ThinShell& shell, const Poses& poses)
{
    Points positions;
    shell.solve({poses}, positions);
    return positions;
}

class ThinShellUpdates : public testing::TestWithParam<bool>
{
protected:
    void SetUp() override
    {
        if (!have_cholmod())
            GTEST_SKIP() << "Eigen's LDLT is always computed whole";
    }

    const int side = 60;
    const SurfaceMesh mesh = shapes::hill(side, side);
    const std::vector<Handle> ends = shapes::ends(mesh, 2.5);
    const std::vector<int> few = patch(side, 12, 14, 4);
    const ThinShellOptions options{.affine_basis = GetParam()};
    // Condition 1e9 at 60 edges a side, times the epsilon, times the size of 60; two orderings.
    const double solved = 1e-5;
};

} // namespace

TEST_P(ThinShellUpdates, an_added_handle_gives_what_a_new_object_gives)
{
    ThinShell shell(mesh, options), fresh(mesh, options);
    shell.set_handles(ends);
    const BindReport report = shell.set_handles(with(ends, few));
    EXPECT_EQ(report.analyses, 1);
    EXPECT_EQ(report.factorizations, 2);
    EXPECT_GT(report.refactored, 0.0);
    EXPECT_LT(report.refactored, 0.8);
    EXPECT_EQ(report.constrained_vertices, 61 * 6 + 16);
    EXPECT_EQ(fresh.set_handles(with(ends, few)).refactored, 1.0);
    EXPECT_LT(shapes::distance(solve(shell, raised), solve(fresh, raised)), solved);
    const Points positions = solve(shell, raised);
    for (int v : few)
        EXPECT_LT((positions.row(v) - mesh.points().row(v) - Eigen::RowVector3d(0, 0, 3)).norm(), 1e-12);
}

TEST_P(ThinShellUpdates, painted_stiffness_gives_what_a_new_object_gives)
{
    Stiffness bending(mesh.vertex_count(), 1.0);
    for (int v : few)
        bending[v] = 10.0;
    ThinShellOptions painted = options;
    painted.bending = bending;
    ThinShell shell(mesh, options), fresh(mesh, painted);
    shell.set_handles(ends);
    fresh.set_handles(ends);
    const Points before = solve(shell, bent);
    const BindReport report = shell.set_stiffness({0.0}, bending, {0.0});
    EXPECT_EQ(report.analyses, 1);
    EXPECT_LT(report.refactored, 0.8);
    // The same ordering: to the last bit.
    EXPECT_EQ(solve(shell, bent), solve(fresh, bent));
    EXPECT_GT(shapes::distance(solve(shell, bent), before), 1e-3);
    EXPECT_EQ(shell.set_stiffness({0.0}, {1.0}, {0.0}).analyses, 1);
    EXPECT_EQ(solve(shell, bent), before);
}

TEST_P(ThinShellUpdates, nothing_changed_computes_nothing)
{
    ThinShell shell(mesh, options);
    shell.set_handles(ends);
    const Points before = solve(shell, bent);
    EXPECT_EQ(shell.set_handles(ends).refactored, 0.0);
    EXPECT_EQ(solve(shell, bent), before);
}

TEST_P(ThinShellUpdates, one_handle_after_the_other_stays_right)
{
    ThinShell shell(mesh, options);
    shell.set_handles(ends);
    std::vector<Handle> handles = ends;
    Poses poses = bent;
    shapes::Random random(3);
    for (int k = 0; k < 6; ++k) {
        handles = with(handles, patch(side, 8 + 7 * k, 10 + 6 * k, 3));
        poses.push_back(shapes::shift(0, 0, random.signed_unit()));
        shell.set_handles(handles);
        ThinShell fresh(mesh, options);
        fresh.set_handles(handles);
        EXPECT_LT(shapes::distance(solve(shell, poses), solve(fresh, poses)), solved) << k;
    }
}

TEST_P(ThinShellUpdates, a_handle_taken_away_makes_a_new_factor)
{
    ThinShell shell(mesh, options), fresh(mesh, options);
    shell.set_handles(with(ends, few));
    const BindReport report = shell.set_handles(ends);
    EXPECT_EQ(report.analyses, 2);
    EXPECT_EQ(report.refactored, 1.0);
    fresh.set_handles(ends);
    EXPECT_EQ(solve(shell, bent), solve(fresh, bent));
}

TEST_P(ThinShellUpdates, an_added_handle_taken_away_again_keeps_the_ordering)
{
    ThinShell shell(mesh, options);
    shell.set_handles(ends);
    const Points before = solve(shell, bent);
    shell.set_handles(with(ends, few));
    EXPECT_EQ(shell.set_handles(ends).analyses, 1);
    EXPECT_EQ(solve(shell, bent), before);
}

TEST_P(ThinShellUpdates, cancelled_at_any_tick_leave_the_same_bits)
{
    ThinShell shell(mesh, options);
    shell.set_handles(ends);
    shell.set_handles(with(ends, few));
    const Points before = solve(shell, raised);
    const std::vector<Handle> more = with(with(ends, few), patch(side, 40, 40, 4));
    Poses poses = raised;
    poses.push_back(shapes::still());
    for (int stop = 1; stop <= 4; ++stop) {
        int ticks = 0;
        EXPECT_THROW(shell.set_handles(more, Progress([&](double, const char*) { return ++ticks < stop; })),
                     Cancelled);
        EXPECT_EQ(solve(shell, raised), before) << "cancelled at tick " << stop;
    }
    shell.set_handles(more);
    EXPECT_EQ(solve(shell, poses).rows(), mesh.vertex_count());
}

TEST_P(ThinShellUpdates, above_the_memory_limit_are_refused)
{
    ThinShell shell(mesh, options);
    shell.set_handles(ends);
    const Points before = solve(shell, bent);
    const MemoryLimit limit(100'000);
    const auto bind = [&] { shell.set_handles(with(ends, few)); };
    const std::string text = refusal<OutOfMemory>(bind).what();
    EXPECT_NE(text.find("the memory limit is 0.1 MB"), std::string::npos) << text;
    EXPECT_EQ(solve(shell, bent), before);
}

INSTANTIATE_TEST_SUITE_P(basis, ThinShellUpdates, testing::Bool());

} // namespace sinew::test_thin_shell_updates
