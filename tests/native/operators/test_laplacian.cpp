// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/laplacian.h"

#include "tests/native/shapes.h"

namespace sinew::test_laplacian {

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
