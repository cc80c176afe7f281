// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/pyramids/problem.h"

#include "native/local_global/rows/row_problem.h"
#include "native/methods/surface/nonlinear/pyramids/morph.h"
#include "tests/native/differences.h"
#include "tests/native/shapes.h"
#include "tests/native/wide_kernels.h"

#include <gtest/gtest.h>

namespace sinew::test_problem {

namespace {

struct Scene
{
    SurfaceMesh mesh;
    Rings rings;
    Rings::Weights weights;
    PyramidStiffness stiffness;
    std::vector<bool> moving;
    PyramidCells cells;
    PyramidShape shape;
    Points noisy, pulls;

    explicit Scene(const SurfaceMesh& of)
        : mesh(of), rings(mesh), weights(rings.mean_value_weights(view(mesh.points()))),
          stiffness(mesh, rings, weights, 0.05), moving(some(rings)),
          cells(rings, weights.shares, stiffness, moving, {{2, 0, 0.5}}), noisy(mesh.points()),
          pulls(Points::Constant(1, 3, 0.3))
    {
        cells.keep(view(mesh.points()), shape);
        shapes::Random random(4);
        for (int i = 0; i < noisy.rows(); ++i)
            if (moving[i])
                noisy.row(i) += 0.2 * random.vector().transpose();
    }

    static std::vector<bool> some(const Rings& rings)
    {
        std::vector<bool> moving(rings.size());
        for (int i = 0; i < rings.size(); ++i)
            moving[i] = rings.valence(i) > 0 && (i == 2 || i % 5 != 0);
        return moving;
    }
    Points at(const Points& points) const
    {
        Points x(cells.moving_count(), 3);
        for (int p = 0; p < x.rows(); ++p)
            x.row(p) = points.row(cells.order()[p]);
        return x;
    }
};

} // namespace

TEST(PyramidProblem, agrees_with_the_table_of_rows)
{
    for (const SurfaceMesh& mesh : {shapes::sphere(2), shapes::hill(9, 7), shapes::messy()}) {
        const Scene own(mesh);
        const int n = mesh.vertex_count();
        RowTable rows(n, n);
        std::vector<bool> held(n);
        for (int i = 0; i < n; ++i) {
            held[i] = !own.moving[i];
            std::vector<RowTable::Term> tip{{i, 1.0}};
            for (int a = own.rings.offsets()[i]; a < own.rings.offsets()[i + 1]; ++a) {
                const int j = own.rings.neighbours()[a];
                tip.push_back({j, -own.weights.shares[a]});
                const RowTable::Term edge[]{{j, 1.0}, {i, -1.0}};
                rows.add(own.stiffness.sides[i], edge, i);
            }
            if (own.rings.valence(i) > 0)
                rows.add(own.stiffness.tips[i], tip, i);
        }
        rows.pull(2, own.cells.pulls().front().stiffness);
        const RowSystem table(rows, mesh.points(), held);
        RowProblem oracle(table, table.rest_vectors(), mesh.points(), own.pulls);
        PyramidBuffers buffers;
        PyramidProblem problem(own.cells, own.shape, false, own.noisy, own.pulls, buffers);
        Points g, expected, all, other = Points::Zero(n, 3);
        const double E = problem.evaluate(own.at(own.noisy), g);
        // Cells of points that are all held are in the table only, and at rest.
        EXPECT_NEAR(oracle.evaluate(table.free_rows(view(own.noisy)), expected), E, 1e-12 * E);
        for (int f = 0; f < table.free_count(); ++f)
            other.row(table.order()[f]) = expected.row(f);
        for (int p = 0; p < own.cells.moving_count(); ++p)
            EXPECT_LT((g.row(p) - other.row(own.cells.order()[p])).norm(), 1e-11 * std::max(1.0, g.norm()));
    }
}

TEST(PyramidProblem, gradient_is_that_of_the_energy)
{
    const Scene own(shapes::hill(8, 7));
    for (const bool scaled : {false, true}) {
        PyramidBuffers buffers;
        PyramidProblem problem(own.cells, own.shape, scaled, own.noisy, own.pulls, buffers);
        Points x = own.at(own.noisy), g, scratch;
        problem.evaluate(x, g);
        const auto F = [&](const Points& there) { return problem.evaluate(there, scratch); };
        expect_gradient(F, x, g, 1e-5, 1e-7 * g.norm(), 3);
    }
}

TEST(PyramidProblem, kernels_agree_to_the_last_bit)
{
    const Scene own(shapes::sphere(3));
    const PyramidKernels* const wide = kernels_with<PyramidKernels>(Instructions::avx2);
    if (!wide)
        GTEST_SKIP() << "no wide instructions here";
    PyramidBuffers buffers;
    PyramidProblem problem(own.cells, own.shape, false, own.noisy, own.pulls, buffers);
    PyramidView seen = own.cells.view();
    seen.edges = own.shape.edges.data();
    seen.tips = own.shape.tips.data();
    seen.points = buffers.points.data();
    const int cells = std::min(own.cells.cell_count(), 200);
    std::vector<double> results[2];
    for (const PyramidKernels* kernels : {&PyramidKernels::baseline, wide}) {
        std::vector<double> S(12 * 201), f(buffers.forces.size()), sums(buffers.sums.size()), g(3 * 201);
        kernels->covariances(seen, 0, cells, S.data());
        f.back() = kernels->forces(seen, 0, cells, buffers.rotations.data(), f.data(), sums.data());
        kernels->gather(seen, 0, std::min(cells, own.cells.moving_count()), f.data(), sums.data(), g.data());
        std::vector<double>& all = results[kernels == wide];
        for (int c = 0; c < cells; ++c)
            for (int k = 0; k < 12; ++k)
                if (k % 4 < 3) // the fourth lanes hold whatever is behind
                    all.push_back(S[12 * c + k]);
        all.insert(all.end(), f.begin(), f.end());
        all.insert(all.end(), sums.begin(), sums.end());
        all.insert(all.end(), g.begin(), g.end());
    }
    EXPECT_EQ(results[0], results[1]);
}

TEST(Rings, coordinates_do_not_change_by_motions_and_sizes)
{
    const SurfaceMesh mesh = shapes::sphere(2);
    const Rings rings(mesh);
    const Rings::Weights weights = rings.mean_value_weights(view(mesh.points()));
    EXPECT_TRUE(weights.folded.empty());
    const auto heights = [&](const Points& points) {
        std::vector<Vector3> found; // sideways, in either direction, and up
        for (int i = 0; i < rings.size(); ++i) {
            const Vector3 N = rings.normal(view(points), i);
            Vector3 tip = Vector3::Zero();
            for (int a = rings.offsets()[i]; a < rings.offsets()[i + 1]; ++a)
                tip += weights.shares[a] * (points.row(i) - points.row(rings.neighbours()[a])).transpose();
            found.emplace_back(0, (tip - tip.dot(N) * N).norm(), tip.dot(N));
        }
        return found;
    };
    const std::vector<Vector3> rest = heights(mesh.points());
    const Points moved = shapes::transformed(mesh.points(), shapes::turn({3, 1, 2}, 170, {1, 2, 3}));
    const Points grown = 2.5 * moved;
    for (int i = 0; i < rings.size(); ++i) {
        EXPECT_LT(rest[i].y(), 1e-14); // the tip stands on its normal
        EXPECT_LT((heights(moved)[i] - rest[i]).norm(), 1e-14);
        EXPECT_LT((heights(grown)[i] - 2.5 * rest[i]).norm(), 2e-14);
    }
    const Rings::Weights again = rings.mean_value_weights(view(grown));
    for (std::size_t a = 0; a < weights.shares.size(); ++a)
        EXPECT_NEAR(again.shares[a], weights.shares[a], 1e-13);
}

TEST(PyramidMorph, mixes_weights_heights_and_edges)
{
    const SurfaceMesh mesh = shapes::hill(8, 7);
    const Scene own(mesh);
    const Points other =
        shapes::Random(9).shaken(shapes::transformed(mesh.points(), shapes::turn({1, 2, 3}, 50)), 0.05);
    const PyramidMorph morph(own.rings, own.weights.shares, other);
    const Rings::Weights its = own.rings.mean_value_weights(view(other));
    PyramidShape shape;
    std::vector<Eigen::Quaterniond> turns;
    for (const double t : {0.0, 0.3, 1.0}) {
        morph.mix(own.cells, own.rings, view(mesh.points()), view(mesh.points()), t, shape, turns);
        for (int c = 0; c < own.cells.cell_count(); ++c) {
            const int i = own.cells.order()[c], first = own.rings.offsets()[i];
            // By weights that are mixed, the tip of the mixed edges is the mixture of the tips.
            Vector3 expected = Vector3::Zero(), by_own = Vector3::Zero(), by_mixed = Vector3::Zero();
            const Matrix3 turn = own.rings.turn(view(mesh.points()), view(other), i).toRotationMatrix();
            for (int a = first; a < own.rings.offsets()[i + 1]; ++a) {
                const int j = own.rings.neighbours()[a];
                const Vector3 p = (mesh.point(j) - mesh.point(i)),
                              q = turn.transpose() * (other.row(j) - other.row(i)).transpose();
                const Eigen::Map<const Vector3> edge(shape.edges.data() +
                                                     3 * (own.cells.offsets()[c] + a - first));
                EXPECT_LT((edge - ((1 - t) * p + t * q)).norm(), 1e-14);
                expected -= (1 - t) * own.weights.shares[a] * p + t * its.shares[a] * q;
                by_own -= own.weights.shares[a] * edge;
                by_mixed -= ((1 - t) * own.weights.shares[a] + t * its.shares[a]) * edge;
            }
            const Eigen::Map<const Vector3> tip(shape.tips.data() + 3 * c);
            EXPECT_LT((tip - by_own + by_mixed - expected).norm(), 1e-14);
        }
    }
}

} // namespace sinew::test_problem
