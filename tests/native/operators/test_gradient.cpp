// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/gradient.h"

#include "native/operators/laplacian.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_gradient {

namespace {

const Vector3 slope(0.3, -1.7, 0.9);

Vector3 normal(const SurfaceMesh& mesh, const Triangle& t)
{
    return (mesh.point(t[1]) - mesh.point(t[0])).cross(mesh.point(t[2]) - mesh.point(t[0])).normalized();
}

} // namespace

TEST(Gradient, of_a_linear_function_is_its_slope_within_each_triangle)
{
    for (const SurfaceMesh& mesh : {shapes::hill(6, 5), shapes::sphere(2), shapes::bar(3, 2)}) {
        const VectorX f = (mesh.points() * slope).array() + 4.0;
        const VectorX gradient = gradient_matrix(mesh) * f;
        for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
            const Vector3 n = normal(mesh, mesh.triangles()[t]);
            const Vector3 expected = slope - slope.dot(n) * n;
            EXPECT_LT((gradient.segment<3>(3 * t) - expected).norm(),
                      1e-13); // values of some ten over edges of one
        }
    }
}

TEST(Gradient, is_zero_on_triangles_without_area)
{
    const SurfaceMesh mesh =
        shapes::mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 1, 3}});
    const MatrixX G = gradient_matrix(mesh);
    EXPECT_EQ(G.topRows(3).cwiseAbs().maxCoeff(), 0.0);
    EXPECT_GT(G.bottomRows(3).cwiseAbs().maxCoeff(), 0.5);
}

TEST(Divergence, of_the_gradient_is_the_cotan_laplacian)
{
    const SurfaceMesh mesh = shapes::hill(6, 5);
    const SparseMatrix product = divergence_matrix(mesh) * gradient_matrix(mesh);
    const MatrixX L = laplacian_matrix(mesh, Discretization::cotan);
    EXPECT_LT((MatrixX(product) - L).cwiseAbs().maxCoeff(), 1e-13 * L.cwiseAbs().maxCoeff());
}

TEST(Divergence, of_any_field_adds_up_to_zero)
{
    const SurfaceMesh mesh = shapes::hill(6, 5);
    const MatrixX field = shapes::Random(2).dense(3 * static_cast<int>(mesh.triangles().size()), 1);
    EXPECT_NEAR((divergence_matrix(mesh) * field).sum(), 0.0, 1e-12); // some hundred terms of size one
}

} // namespace sinew::test_gradient
