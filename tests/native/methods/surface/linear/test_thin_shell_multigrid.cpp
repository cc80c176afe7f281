// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/thin_shell.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_thin_shell_multigrid {

namespace {

class ThinShellMultigrid : public SurfaceFixture<sinew::ThinShell, ThinShellOptions>
{
};

const Poses bent{shapes::turn({0, 1, 0}, 40), shapes::shift(1, -2, 30)};

/// The largest distance between the shapes by multigrid and by factor, as a share of the largest motion.
double difference(const SurfaceMesh& mesh, const std::vector<Handle>& handles, ThinShellOptions options)
{
    options.solver = SystemSolver::factor;
    const Points expected = ThinShellMultigrid::solved(mesh, handles, {.poses = bent}, options);
    options.solver = SystemSolver::multigrid;
    SolveReport report;
    const Points found = ThinShellMultigrid::solved(mesh, handles, {.poses = bent}, options, &report);
    EXPECT_TRUE(report.converged);
    EXPECT_GT(report.iterations, 1);
    return shapes::distance(found, expected) / shapes::distance(expected, mesh.points());
}

} // namespace

TEST_F(ThinShellMultigrid, gives_the_shape_of_the_factor)
{
    const SurfaceMesh hill = shapes::hill(90, 80), messy = shapes::messy();
    std::vector<Handle> soft = shapes::ends(hill, 3), crease = soft;
    soft[1].weights.assign(soft[1].vertices.size(), 0.7);
    crease[0].continuity = 0.0;
    std::vector<double> painted(hill.vertex_count(), 1.0);
    for (int i = 0; i < hill.vertex_count(); i += 7)
        painted[i] = 0.3;
    for (const std::vector<Handle>& handles : {shapes::ends(hill, 3), soft, crease})
        for (const ThinShellOptions& options :
             {ThinShellOptions{}, ThinShellOptions{.stretching = {1.0}, .bending = {0.0}},
              ThinShellOptions{.stretching = {0.01}, .bending = painted},
              ThinShellOptions{.stretching = painted, .bending = {0.0}}})
            EXPECT_LT(difference(hill, handles, options), 1e-4);
    EXPECT_LT(difference(messy, shapes::ends(messy, 1.5), {}), 1e-4);
}

TEST_F(ThinShellMultigrid, a_solve_ends_within_a_product_and_begins_from_a_shape)
{
    const SurfaceMesh mesh = shapes::hill(90, 80);
    const Method shell = bound(mesh, {.solver = SystemSolver::multigrid}, shapes::ends(mesh, 3));
    const Solution first = solve(shell, bent);
    for (int stop : {1, 20, 100}) {
        int ticks = 0;
        EXPECT_THROW(solve(shell, bent, {.progress = Progress([&](double, const char*) {
                                             return ++ticks < stop;
                                         })}),
                     Cancelled);
        EXPECT_EQ(ticks, stop);
    }
    EXPECT_EQ(solve(shell, bent).positions, first.positions);
    const Solution again = solve(shell, bent, {.start = view(first.positions)});
    EXPECT_LT(again.report.iterations, first.report.iterations / 2);
    EXPECT_NEAR(again.report.energy, first.report.energy, 1e-4 * first.report.energy);
}

TEST_F(ThinShellMultigrid, is_chosen_where_the_factor_is_too_large_and_both_are_refused_above_the_limit)
{
    const SurfaceMesh mesh = shapes::hill(160, 140);
    const std::vector<Handle> ends = shapes::ends(mesh, 3);
    Method shell(mesh);
    const BindReport whole = shell.set_handles(ends);
    EXPECT_TRUE(whole.remarks.empty());
    const Points by_factor = solve(shell, bent).positions;
    {
        const MemoryLimit limit(whole.factor_bytes - 1);
        const BindReport less = Method(mesh).set_handles(ends);
        ASSERT_EQ(less.remarks.size(), 1U);
        EXPECT_NE(less.remarks.front().find("the factor needs "), std::string::npos) << less.remarks.front();
        EXPECT_LT(less.factor_bytes, whole.factor_bytes);
    }
    const MemoryLimit limit(2'000'000);
    const auto error = refusal<OutOfMemory>([&] { shell.set_handles(shapes::ends(mesh, 4)); });
    EXPECT_NE(std::string(error.what()).find(" and the multigrid needs "), std::string::npos) << error.what();
    EXPECT_EQ(solve(shell, bent).positions, by_factor);
}

} // namespace sinew::test_thin_shell_multigrid
