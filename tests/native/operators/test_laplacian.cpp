// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/laplacian.h"

#include "native/mesh/components.h"
#include "tests/native/dense.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sinew::test_laplacian {

namespace {

constexpr std::array every{Discretization::uniform, Discretization::cotan, Discretization::cotan_voronoi};
constexpr auto cotan = Discretization::cotan;
using dense::largest;
constexpr auto voronoi = Discretization::cotan_voronoi;

double total_area(const SurfaceMesh& mesh)
{
    double area = 0.0;
    for (const auto& [a, b, c] : mesh.triangles())
        area += 0.5 * (mesh.point(b) - mesh.point(a)).cross(mesh.point(c) - mesh.point(a)).norm();
    return area;
}

/// Slivers, needles and caps of random shape between two regular rows.
SurfaceMesh slivers()
{
    Points p = shapes::grid_points(6, 6);
    shapes::Random random(8);
    for (int i = 0; i < p.rows(); ++i)
        p(i, 1) = std::pow(10.0, -8 * random.unit()) * p(i, 1) + 1e-3 * p(i, 1);
    return shapes::moved(shapes::grid(6, 6), p);
}

} // namespace

TEST(Laplacian, is_symmetric_and_of_a_constant_zero)
{
    for (const SurfaceMesh& mesh : {shapes::hill(7, 6), shapes::messy(), shapes::bar(5, 2), slivers()})
        for (Discretization kind : every) {
            const SparseMatrix L = laplacian_matrix(mesh, kind);
            const VectorX sums = L * VectorX::Ones(mesh.vertex_count());
            EXPECT_LE(sums.cwiseAbs().maxCoeff(), 1e-14 * largest(L)); // some ten terms a row
            // The same terms, summed otherwise.
            EXPECT_LE(largest(L - SparseMatrix(L.transpose())), 1e-15 * largest(L));
        }
}

TEST(Laplacian, weights_of_a_square_grid_are_one_half_at_the_border_and_zero_on_diagonals)
{
    const MatrixX L = laplacian_matrix(shapes::grid(2, 2), cotan);
    EXPECT_NEAR(L(1, 4), -1.0, 1e-15); // inner edge: cot 45 from both sides
    EXPECT_NEAR(L(0, 1), -0.5, 1e-15); // border edge
    EXPECT_NEAR(L(0, 4), 0.0, 1e-15);  // diagonal: cot 90
    EXPECT_NEAR(L(4, 4), 4.0, 1e-15);
}

TEST(Laplacian, weights_of_equilateral_triangles_are_half_the_cotangent_of_60_degrees_a_side)
{
    const MatrixX L = laplacian_matrix(shapes::octahedron(), cotan);
    EXPECT_NEAR(L(0, 2), -1 / std::sqrt(3.0), 1e-15);
    EXPECT_NEAR(L(0, 1), 0.0, 1e-15);
}

TEST(Laplacian, uniform_counts_polygon_edges_once)
{
    const MatrixX L = laplacian_matrix(shapes::quad_grid(1, 1), Discretization::uniform);
    MatrixX expected(4, 4);
    expected << 2, -1, -1, 0, -1, 2, 0, -1, -1, 0, 2, -1, 0, -1, -1, 2;
    EXPECT_EQ(L, expected);
}

TEST(Laplacian, has_one_zero_eigenvalue_a_component)
{
    const SurfaceMesh several =
        shapes::joined(shapes::joined(shapes::sphere(2), shapes::hill(5, 4), {5, 0, 0}),
                       shapes::mesh({{0, 0, 0}}, {}), {9, 9, 9});
    for (const SurfaceMesh& mesh : {several, shapes::messy(), shapes::cube()})
        for (Discretization kind : every) {
            const VectorX values = dense::eigenvalues(laplacian_matrix(mesh, kind));
            // Rounding gives some 1e-15 of the largest. The floored triangles of `messy` have
            // cotangents of 1e5, its smallest true eigenvalue is about 1e-7 of the largest.
            const double zero = 1e-11 * values.maxCoeff();
            EXPECT_EQ((values.array() < zero).count(), connected_components(mesh).count);
        }
}

TEST(Laplacian, is_semi_definite_on_slivers_and_faces_without_area)
{
    for (const SurfaceMesh& mesh :
         {slivers(), shapes::messy(), shapes::moved(shapes::grid(4, 4), Points::Zero(25, 3))})
        for (Discretization kind : every) {
            const SparseMatrix L = laplacian_matrix(mesh, kind);
            ASSERT_TRUE(MatrixX(L).allFinite());
            const VectorX values = dense::eigenvalues(L);
            // Rounding of entries the size of the largest; n of them in a row at most.
            EXPECT_GE(values.minCoeff(), -1e-14 * std::max(1e-300, values.maxCoeff()));
        }
}

TEST(Laplacian, a_face_without_area_still_ties_its_corners)
{
    const SurfaceMesh mesh = shapes::mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}});
    const VectorX values = dense::eigenvalues(laplacian_matrix(mesh, cotan));
    EXPECT_EQ((values.array() < 1e-12 * values.maxCoeff()).count(), 1);
    EXPECT_EQ(triangle_metric(mesh).degenerate, std::vector{0});
    EXPECT_EQ(triangle_metric(mesh).area[0], 0.0);
}

TEST(Laplacian, thin_triangles_that_are_not_degenerate_keep_their_cotangents)
{
    const double h = 1e-3; // angles of 2e-3: two hundred times the floor
    const SurfaceMesh mesh = shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0.5, h, 0}}, {{0, 1, 2}});
    const MatrixX L = laplacian_matrix(mesh, cotan);
    EXPECT_TRUE(triangle_metric(mesh).degenerate.empty());
    EXPECT_NEAR(L(0, 2), -0.5 * 0.5 / h, 1e-9); // half the cotangent at corner 1
    // Half the cotangent at corner 2, of the angle pi - 2 atan(0.5 / h).
    EXPECT_NEAR(L(0, 1), -0.5 * std::tan(std::atan(h / 0.5) - std::atan(0.5 / h)), 1e-6);
}

TEST(Laplacian, scales_each_element)
{
    const SurfaceMesh mesh = shapes::hill(4, 4);
    for (Discretization kind : every) {
        const SparseMatrix L = laplacian_matrix(mesh, kind);
        const SparseMatrix doubled = laplacian_matrix(mesh, kind, [](std::span<const int>) { return 2.0; });
        EXPECT_LT(largest(MatrixX(doubled - 2 * L)), 1e-14 * largest(L));
        // Elements split in two sets: the parts add up to the whole.
        const auto low = [](std::span<const int> v) { return *std::ranges::min_element(v) < 10 ? 1.0 : 0.0; };
        const auto high = [&](std::span<const int> v) { return 1.0 - low(v); };
        const SparseMatrix sum = laplacian_matrix(mesh, kind, low) + laplacian_matrix(mesh, kind, high);
        EXPECT_LT(largest(MatrixX(sum - L)), 1e-14 * largest(L));
    }
}

TEST(Laplacian, does_not_depend_on_the_size_of_the_mesh)
{
    const SurfaceMesh mesh = shapes::hill(5, 5);
    const SparseMatrix L = laplacian_matrix(mesh, cotan);
    for (double scale : {1e-12, 1e12}) {
        const SparseMatrix scaled = laplacian_matrix(shapes::moved(mesh, scale * mesh.points()), cotan);
        EXPECT_LT(largest(MatrixX(scaled - L)), 1e-12 * largest(L));
    }
}

TEST(Mass, adds_up_to_the_area)
{
    for (const SurfaceMesh& mesh : {shapes::hill(7, 6), shapes::messy(), shapes::bar(5, 2), slivers(),
                                    shapes::sphere(3), shapes::quad_grid(3, 4)}) {
        const VectorX mass = mass_vector(mesh, voronoi);
        EXPECT_NEAR(mass.sum(), total_area(mesh), 1e-12 * total_area(mesh)); // a few hundred terms
        EXPECT_GE(mass.minCoeff(), 0.0);
    }
}

TEST(Mass, of_a_triangle_is_its_voronoi_area_or_half_and_quarters_where_it_is_obtuse)
{
    struct Case
    {
        Vector3 b, c; ///< the first corner is the origin
        Vector3 mass;
    };
    for (const Case& at : {Case{{1, 0, 0}, {0, 1, 0}, {0.25, 0.125, 0.125}}, // right
                           Case{{4, 0, 0}, {1, 1, 0}, {0.5, 0.5, 1.0}},      // obtuse
                           Case{{4, 0, 0}, {1, 3, 0}, {2.25, 1.75, 2.0}}})   // acute, about (2, 1)
        EXPECT_LT((mass_vector(shapes::mesh({Vector3::Zero(), at.b, at.c}, {{0, 1, 2}}), voronoi) - at.mass)
                      .cwiseAbs()
                      .maxCoeff(),
                  1e-15);
}

TEST(Mass, is_one_for_cotan_and_the_number_of_neighbours_for_uniform)
{
    EXPECT_EQ(mass_vector(shapes::cube(), cotan), VectorX::Ones(8));
    EXPECT_EQ(mass_vector(shapes::cube(), Discretization::uniform), VectorX::Constant(8, 3));
}

TEST(Mass, is_zero_at_loose_vertices_and_raised_before_it_divides)
{
    const SurfaceMesh mesh = shapes::messy();
    const int loose = mesh.vertex_count() - 1;
    const VectorX mass = mass_vector(mesh, voronoi);
    EXPECT_EQ(mass[loose], 0.0);
    const VectorX raised = divisible_mass(mesh, voronoi);
    EXPECT_DOUBLE_EQ(raised[loose], 1e-6 * mass.mean());
    EXPECT_EQ(raised[12], mass[12]);
    EXPECT_GT(divisible_mass(SurfaceMesh(Points::Zero(3, 3), {}, {}), voronoi).minCoeff(), 0.0);
}

} // namespace sinew::test_laplacian
