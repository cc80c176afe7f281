// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/laplacian.h"

#include "tests/native/shapes.h"

namespace sinew::test_laplacian {

// Other tests of it are in tests/bindings/oracles/test_oracles_linear.py, against libigl.
TEST(TriangleMetric, names_the_faces_without_area)
{
    const SurfaceMesh mesh = shapes::mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0.5, 1e-3, 0}},
                                          {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}});
    EXPECT_EQ(triangle_metric(mesh).degenerate, std::vector{0});
    EXPECT_EQ(triangle_metric(mesh).area[0], 0.0);
}

TEST(Mass, is_zero_at_loose_vertices_and_raised_before_it_divides)
{
    constexpr auto voronoi = Discretization::cotan_voronoi;
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
