// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/turned_gradients.h"

#include "native/operators/gradient.h"
#include "tests/native/shapes.h"

namespace sinew::test_turned_gradients {

RowMatrix source(const TurnedGradients& turned, const Points& y, const std::vector<Matrix3>& maps,
                 double* sum)
{
    RowMatrix b(y.rows(), 3);
    std::vector<Vector3> forces;
    *sum = turned.source(
        view(y),
        [&](int t, Vector3& first, Vector3& second) {
            first = (maps[t] * first - first).eval();
            second = (maps[t] * second - second).eval();
        },
        forces, b);
    return b;
}

TEST(TurnedGradients, are_those_of_the_gradient_matrix_turned_by_the_transpose)
{
    for (const SurfaceMesh& mesh : {shapes::hill(6, 5), shapes::sphere(2), shapes::bar(3, 2)}) {
        shapes::Random random(5);
        const Points y = mesh.points() + 0.3 * random.dense(mesh.vertex_count(), 3);
        std::vector<Matrix3> maps;
        MatrixX G = gradient_matrix(mesh) * y; // rows 3t are d/dx, d/dy, d/dz of x, y, z
        const MatrixX before = G;
        for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
            maps.push_back(random.matrix());
            G.middleRows<3>(3 * t) *= maps.back().transpose();
        }
        double sum = 0.0;
        const RowMatrix b = source(TurnedGradients(mesh, triangle_metric(mesh)), y, maps, &sum);
        EXPECT_LT((b - divergence_matrix(mesh) * (G - before)).cwiseAbs().maxCoeff(), 1e-13);
        double expected = 0.0;
        for (std::size_t t = 0; t < mesh.triangles().size(); ++t)
            expected += triangle_metric(mesh).area[t] * (G - before).middleRows<3>(3 * t).squaredNorm();
        EXPECT_NEAR(sum, expected, 1e-13 * expected);
    }
}

TEST(TurnedGradients, of_one_map_are_the_laplacian_of_the_mapped_points_even_on_needles)
{
    const SurfaceMesh mesh = shapes::messy();
    const Matrix3 map = shapes::Random(2).matrix();
    const TriangleMetric metric = triangle_metric(mesh);
    ASSERT_FALSE(metric.degenerate.empty());
    double sum = 0.0;
    const RowMatrix b = source(TurnedGradients(mesh, metric), mesh.points(),
                               std::vector<Matrix3>(mesh.triangles().size(), map), &sum);
    const SparseMatrix L = laplacian_matrix(mesh, Discretization::cotan, metric);
    const Points change = mesh.points() * (map - Matrix3::Identity()).transpose();
    EXPECT_LT((b - L * change).cwiseAbs().maxCoeff(),
              1e-15 * L.coeffs().abs().maxCoeff() * shapes::size(change));
    EXPECT_NEAR(sum, (change.transpose() * (L * change)).trace(), 1e-12 * sum);
}

TEST(TurnedGradients, are_exactly_zero_where_nothing_turns)
{
    const SurfaceMesh mesh = shapes::messy();
    double sum = 1.0;
    const RowMatrix b = source(TurnedGradients(mesh, triangle_metric(mesh)), mesh.points(),
                               std::vector<Matrix3>(mesh.triangles().size(), Matrix3::Identity()), &sum);
    EXPECT_EQ(b.cwiseAbs().maxCoeff(), 0.0);
    EXPECT_EQ(sum, 0.0);
}

} // namespace sinew::test_turned_gradients
