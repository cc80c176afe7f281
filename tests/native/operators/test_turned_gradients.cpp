// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/turned_gradients.h"

#include "native/operators/laplacian.h"
#include "tests/native/shapes.h"

namespace sinew::test_turned_gradients {

// On other meshes they are those of gradient matrices in tests/bindings/oracles/test_oracles_surface.py.
TEST(TurnedGradients, of_one_map_are_the_laplacian_of_the_mapped_points_even_on_needles)
{
    const SurfaceMesh mesh = shapes::messy();
    const TriangleMetric metric = triangle_metric(mesh);
    ASSERT_FALSE(metric.degenerate.empty());
    const SparseMatrix L = laplacian_matrix(mesh, Discretization::cotan, metric);
    for (const Matrix3& turn : {shapes::Random(2).matrix(), Matrix3(Matrix3::Identity())}) {
        RowMatrix b(mesh.vertex_count(), 3);
        std::vector<Vector3> forces;
        const double sum = TurnedGradients(mesh, metric)
                               .source(
                                   view(mesh.points()),
                                   [&](int, Vector3& first, Vector3& second) {
                                       first = (turn * first - first).eval();
                                       second = (turn * second - second).eval();
                                   },
                                   forces, b);
        const Points change = mesh.points() * (turn - Matrix3::Identity()).transpose();
        EXPECT_LE((b - L * change).cwiseAbs().maxCoeff(),
                  1e-15 * L.coeffs().abs().maxCoeff() * shapes::size(change)); // zero where nothing turns
        EXPECT_NEAR(sum, (change.transpose() * (L * change)).trace(), 1e-12 * sum);
    }
}

} // namespace sinew::test_turned_gradients
