// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/rows/row_problem.h"

#include "native/local_global/arap/arap_problem.h"
#include "native/local_global/arap/multilevel_start.h"
#include "tests/native/local_global/arap/graphs.h"
#include "tests/native/shapes.h"

namespace sinew::test_row_problem {

const Poses bent{shapes::still(), shapes::turn({1, 0, 0}, 30, {0, 0, 1}, {0.2, 0.4, 0.3})};

/// A sphere held by its poles, with the rows of its as-rigid-as-possible energy. Group i is vertex i.
struct Setting
{
    SurfaceMesh mesh = shapes::sphere(2);
    ArapSystem graph;
    GraphGoals goals;
    RowSystem cells;

    explicit Setting(double smoothness)
        : graph(graphs::of(mesh, graphs::poles(mesh), smoothness, false, true)),
          goals(graph, Targets{bent, view(mesh.points()), {}, nullptr}),
          cells(rows(), mesh.points(), held(), {}, {.field = true})
    {
    }
    RowProblem problem() const { return RowProblem(cells, cells.rest_vectors(), goals.targets); }
    ArapProblem oracle() const { return ArapProblem(graph, view(mesh.points()), goals.targets, goals.pulls); }
    /// A gradient of the oracle in the order of the table's free points.
    Points reordered(const Points& of_nodes) const
    {
        Points all = Points::Zero(graph.size(), 3);
        all.topRows(graph.free_count()) = of_nodes;
        return cells.free_rows(view(all));
    }

private:
    std::vector<bool> held() const
    {
        std::vector<bool> flags(graph.size());
        for (int i = 0; i < graph.size(); ++i)
            flags[i] = graph.nodes().place(i) < 0;
        return flags;
    }
    /// Those of E / 4, as ArapProblem has it.
    RowTable rows() const
    {
        const GraphEdges& edges = graph.nodes().edges();
        const GraphCells& of = graph.cells();
        RowTable table(graph.size(), graph.size());
        for (int i = 0; i < graph.size(); ++i)
            for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a) {
                const int j = edges.neighbours[a];
                const RowTable::Term terms[]{{i, 1.0}, {j, -1.0}};
                table.add(0.5 * of.rigidity[i] * edges.weights[a], terms, i);
                if (of.smoothing > 0)
                    table.align(i, j, 0.25 * of.smoothing * of.edge_rigidity(i, j) * edges.weights[a]);
            }
        return table;
    }
};

TEST(RowProblem, a_table_of_arap_agrees_with_its_own_kernels)
{
    const Setting setting(0.0);
    RowProblem problem = setting.problem();
    ArapProblem oracle = setting.oracle();
    const Points at = shapes::Random(2).shaken(setting.mesh.points(), 0.1);
    Points gradient, expected, x, x_expected;
    for (int k = 0; k < 2; ++k) { // `tie` has no effect on the second
        const double F = problem.evaluate(setting.cells.free_rows(view(at)), gradient);
        EXPECT_NEAR(F, oracle.evaluate(oracle.free_rows(view(at)), expected), 1e-12 * F);
    }
    EXPECT_LT(shapes::distance(gradient, setting.reordered(expected)), 1e-12);
    problem.global_step(x);
    oracle.global_step(x_expected);
    EXPECT_LT(shapes::distance(x, setting.reordered(x_expected)), 2e-7); // one solve in single precision
    oracle.global_step(x_expected);
    EXPECT_LT(shapes::distance(x, setting.reordered(x_expected)), 1e-11); // two
}

TEST(RowProblem, a_smooth_table_of_arap_ends_where_its_own_kernels_do)
{
    const Setting setting(0.02);
    RowProblem problem = setting.problem();
    ArapProblem oracle = setting.oracle();
    Points x = setting.cells.free_rows(view(setting.mesh.points()));
    Points y = oracle.free_rows(view(setting.mesh.points()));
    const LbfgsOptions deep{.max_iterations = 300, .tolerance = 1e-14};
    const double F = minimize(problem, x, deep).energy;
    EXPECT_NEAR(F, minimize(oracle, y, deep).energy, 1e-11 * F);
    // Where F no longer changes by 1e-14, positions still do by the root of that.
    EXPECT_LT(shapes::distance(x, setting.reordered(y)), 1e-6);
}

TEST(RowProblem, cells_of_four_points_are_their_rows_summed_up)
{
    const SurfaceMesh mesh = shapes::sphere(2);
    shapes::Random random(5);
    const int cells = static_cast<int>(mesh.triangles().size());
    RowTable rows(mesh.vertex_count(), cells);
    std::vector<bool> held(mesh.vertex_count());
    for (int i = 0; i < mesh.vertex_count(); ++i)
        held[i] = std::abs(mesh.point(i).z()) > 0.8;
    for (int t = 0; t < cells; ++t) {
        const Triangle& v = mesh.triangles()[t];
        for (int k = 0; k < 3; ++k) {
            const RowTable::Term edge[]{{v[k], 1.0}, {v[(k + 1) % 3], -1.0}};
            rows.add(random.unit(), edge, t);
        }
        const int fourth = random.below(mesh.vertex_count());
        const RowTable::Term fold[]{{v[0], 2.0}, {v[1], -1.5}, {v[2], 0.5}, {fourth, -1.0}};
        rows.add(0.3, fold, t);
    }
    const RowSystem summed(rows, mesh.points(), held);
    const RowSystem plain(rows, mesh.points(), held, {}, {.four_points = false});
    ASSERT_TRUE(summed.has_four_points());
    ASSERT_FALSE(plain.has_four_points());
    EXPECT_NEAR(summed.scale(summed.rest_vectors()), plain.scale(plain.rest_vectors()), 1e-10);
    RowProblem a(summed, summed.rest_vectors(), mesh.points());
    RowProblem b(plain, plain.rest_vectors(), mesh.points());
    const Points all = random.shaken(mesh.points(), 0.2);
    Points of_a, of_b;
    for (int k = 0; k < 2; ++k) {
        const double E = a.evaluate(summed.free_rows(view(all)), of_a);
        EXPECT_NEAR(E, b.evaluate(plain.free_rows(view(all)), of_b), 1e-12 * E);
    }
    EXPECT_LT(shapes::distance(of_a, of_b),
              1e-11); // both number the free points alike: the matrix is the same
    // The plain step in the metric never raises the energy of a table without pairs.
    Points x = summed.free_rows(view(all)), z;
    double E = a.evaluate(x, of_a);
    for (int k = 0; k < 20; ++k) {
        a.precondition(of_a, z);
        x -= z;
        const double next = a.evaluate(x, of_a);
        EXPECT_LE(next, E * (1 + 1e-12)) << "step " << k;
        E = next;
    }
}

} // namespace sinew::test_row_problem
