// SPDX-License-Identifier: GPL-3.0-or-later
// Binds that keep most of the factor that stands.
#include "native/methods/surface/linear/thin_shell.h"

#include "native/solvers/engines/cholmod_factor.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <vector>

namespace sinew::test_thin_shell_updates {

namespace {

/// Of as many handles as are bound: both ends, then those that were added.
Points solve(const ThinShell& shell)
{
    Poses poses{shapes::still(), shapes::turn({0, 1, 0}, 40, {6, 0, 0}, {-1, 0.5, 2})};
    for (int h = 2; h < shell.regions().handle_count(); ++h)
        poses.push_back(shapes::shift(0, 0, 3.0 / h));
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
        shell.set_handles(ends);
        before = solve(shell);
    }
    /// The vertices [x, x + width) x [y, y + width).
    static std::vector<int> patch(int x, int y, int width)
    {
        std::vector<int> vertices;
        for (int j = y; j < y + width; ++j)
            for (int i = x; i < x + width; ++i)
                vertices.push_back(j * 61 + i);
        return vertices;
    }
    static ThinShell bound(const ThinShellOptions& options, const std::vector<Handle>& handles)
    {
        ThinShell fresh(mesh, options);
        EXPECT_EQ(fresh.set_handles(handles).refactored, 1.0);
        return fresh;
    }

    inline static const SurfaceMesh mesh = shapes::hill(60, 60);
    const std::vector<Handle> ends = shapes::ends(mesh, 2.5);
    const std::vector<int> few = patch(12, 14, 4);
    const std::vector<Handle> three{ends[0], ends[1], {few, {}}};
    const ThinShellOptions options{.affine_basis = GetParam()};
    ThinShell shell{mesh, options};
    Points before;
    // Condition 1e9 at 60 edges a side, times the epsilon, times the size of 60; two orderings.
    const double solved = 1e-5;
};

} // namespace

TEST_P(ThinShellUpdates, an_added_handle_gives_what_a_new_object_gives_and_taken_away_what_was_before)
{
    const BindReport report = shell.set_handles(three);
    EXPECT_EQ(report.analyses, 1);
    EXPECT_EQ(report.factorizations, 2);
    EXPECT_GT(report.refactored, 0.0);
    EXPECT_LT(report.refactored, 0.8);
    EXPECT_EQ(report.constrained_vertices, 61 * 6 + 16);
    const Points positions = solve(shell);
    EXPECT_LT(shapes::distance(positions, solve(bound(options, three))), solved);
    for (int v : few)
        EXPECT_LT((positions.row(v) - mesh.points().row(v) - Eigen::RowVector3d(0, 0, 1.5)).norm(), 1e-12);
    EXPECT_EQ(shell.set_handles(ends).analyses, 1) << "the ordering is kept";
    EXPECT_EQ(solve(shell), before);
    EXPECT_EQ(shell.set_handles(ends).refactored, 0.0) << "nothing changed";
    EXPECT_EQ(solve(shell), before);
}

TEST_P(ThinShellUpdates, painted_stiffness_gives_what_a_new_object_gives)
{
    Stiffness bending(mesh.vertex_count(), 1.0);
    for (int v : few)
        bending[v] = 10.0;
    ThinShellOptions painted = options;
    painted.bending = bending;
    const BindReport report = shell.set_stiffness({0.0}, bending, {0.0});
    EXPECT_EQ(report.analyses, 1);
    EXPECT_LT(report.refactored, 0.8);
    EXPECT_EQ(solve(shell), solve(bound(painted, ends))) << "the same ordering: to the last bit";
    EXPECT_GT(shapes::distance(solve(shell), before), 1e-3);
    EXPECT_EQ(shell.set_stiffness({0.0}, {1.0}, {0.0}).analyses, 1);
    EXPECT_EQ(solve(shell), before);
}

TEST_P(ThinShellUpdates, one_handle_after_the_other_stays_right)
{
    std::vector<Handle> handles = ends;
    for (int k = 0; k < 6; ++k) {
        handles.push_back({patch(8 + 7 * k, 10 + 6 * k, 3), {}});
        shell.set_handles(handles);
        EXPECT_LT(shapes::distance(solve(shell), solve(bound(options, handles))), solved) << k;
    }
}

TEST_P(ThinShellUpdates, a_handle_taken_away_makes_a_new_factor)
{
    ThinShell other = bound(options, three);
    const BindReport report = other.set_handles(ends);
    EXPECT_EQ(report.analyses, 2);
    EXPECT_EQ(report.refactored, 1.0);
    EXPECT_EQ(solve(other), before);
}

TEST_P(ThinShellUpdates, cancelled_or_above_the_memory_limit_leave_the_same_bits)
{
    for (int stop = 1; stop <= 4; ++stop) {
        int ticks = 0;
        EXPECT_THROW(shell.set_handles(three, Progress([&](double, const char*) { return ++ticks < stop; })),
                     Cancelled);
        EXPECT_EQ(solve(shell), before) << "cancelled at tick " << stop;
    }
    {
        const MemoryLimit limit(100'000);
        EXPECT_THROW(shell.set_handles(three), OutOfMemory);
    }
    EXPECT_EQ(solve(shell), before);
    shell.set_handles(three);
    EXPECT_LT(shapes::distance(solve(shell), solve(bound(options, three))), solved);
}

INSTANTIATE_TEST_SUITE_P(basis, ThinShellUpdates, testing::Bool());

} // namespace sinew::test_thin_shell_updates
